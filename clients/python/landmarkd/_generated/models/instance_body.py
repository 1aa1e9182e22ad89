from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from attrs import define as _attrs_define
from attrs import field as _attrs_field

if TYPE_CHECKING:
    from ..models.placement_body import PlacementBody


T = TypeVar("T", bound="InstanceBody")


@_attrs_define
class InstanceBody:
    """Something known that is in the frame."""

    label: str
    confidence: float
    """ Probability of being right. """
    placement: PlacementBody
    """ An exemplar laid on the frame. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        label = self.label

        confidence = self.confidence

        placement = self.placement.to_dict()

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "label": label,
                "confidence": confidence,
                "placement": placement,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.placement_body import PlacementBody

        d = dict(src_dict)
        label = d.pop("label")

        confidence = d.pop("confidence")

        placement = PlacementBody.from_dict(d.pop("placement"))

        instance_body = cls(
            label=label,
            confidence=confidence,
            placement=placement,
        )

        instance_body.additional_properties = d
        return instance_body

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
