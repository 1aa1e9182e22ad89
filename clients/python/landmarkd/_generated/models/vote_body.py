from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from ..types import UNSET, Unset

if TYPE_CHECKING:
    from ..models.placement_body import PlacementBody


T = TypeVar("T", bound="VoteBody")


@_attrs_define
class VoteBody:
    """The votes for a label."""

    label: str
    weight: float
    """ W of the label. """
    share: float
    """ Its part of all W. """
    points: int
    """ Votes that counted for it: of interest points, or with `placement` of their sub-windows. """
    placement: None | PlacementBody | Unset = UNSET
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        from ..models.placement_body import PlacementBody

        label = self.label

        weight = self.weight

        share = self.share

        points = self.points

        placement: dict[str, Any] | None | Unset
        if isinstance(self.placement, Unset):
            placement = UNSET
        elif isinstance(self.placement, PlacementBody):
            placement = self.placement.to_dict()
        else:
            placement = self.placement

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "label": label,
                "weight": weight,
                "share": share,
                "points": points,
            }
        )
        if placement is not UNSET:
            field_dict["placement"] = placement

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.placement_body import PlacementBody

        d = dict(src_dict)
        label = d.pop("label")

        weight = d.pop("weight")

        share = d.pop("share")

        points = d.pop("points")

        def _parse_placement(data: object) -> None | PlacementBody | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                placement_type_0 = PlacementBody.from_dict(data)

                return placement_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(None | PlacementBody | Unset, data)

        placement = _parse_placement(d.pop("placement", UNSET))

        vote_body = cls(
            label=label,
            weight=weight,
            share=share,
            points=points,
            placement=placement,
        )

        vote_body.additional_properties = d
        return vote_body

    @property
    def additional_keys(self) -> list[str]:
        return list(self.additional_properties.keys())

    def __getitem__(self, key: str) -> Any:
        return self.additional_properties[key]

    def __setitem__(self, key: str, value: Any) -> None:
        self.additional_properties[key] = value

    def __delitem__(self, key: str) -> None:
        del self.additional_properties[key]

    def __contains__(self, key: str) -> bool:
        return key in self.additional_properties
