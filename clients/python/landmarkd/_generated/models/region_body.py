from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from ..types import UNSET, Unset

T = TypeVar("T", bound="RegionBody")


@_attrs_define
class RegionBody:
    """A connected part of a picture that stands out from its background."""

    id: int
    """ From 1, the largest first; its pixels have this value in the label image. """
    area_px: int
    """ Its pixels. """
    centroid_px: list[float]
    """ The mean of its pixels, x and y. """
    bbox_px: list[int]
    """ x, y, width and height of the smallest upright rectangle around it. """
    elongation: float
    """ Length over breadth, by its second moments. """
    touches_border: bool
    """ Whether the picture cuts it, so that a part of it may be outside. """
    orientation_deg: float | None | Unset = UNSET
    """ Direction of its principal axis, in [-90, 90), from x towards y; null for one that is as broad as long. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        id = self.id

        area_px = self.area_px

        centroid_px = self.centroid_px

        bbox_px = self.bbox_px

        elongation = self.elongation

        touches_border = self.touches_border

        orientation_deg: float | None | Unset
        if isinstance(self.orientation_deg, Unset):
            orientation_deg = UNSET
        else:
            orientation_deg = self.orientation_deg

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "id": id,
                "area_px": area_px,
                "centroid_px": centroid_px,
                "bbox_px": bbox_px,
                "elongation": elongation,
                "touches_border": touches_border,
            }
        )
        if orientation_deg is not UNSET:
            field_dict["orientation_deg"] = orientation_deg

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        id = d.pop("id")

        area_px = d.pop("area_px")

        centroid_px = cast(list[float], d.pop("centroid_px"))

        bbox_px = cast(list[int], d.pop("bbox_px"))

        elongation = d.pop("elongation")

        touches_border = d.pop("touches_border")

        def _parse_orientation_deg(data: object) -> float | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(float | None | Unset, data)

        orientation_deg = _parse_orientation_deg(d.pop("orientation_deg", UNSET))

        region_body = cls(
            id=id,
            area_px=area_px,
            centroid_px=centroid_px,
            bbox_px=bbox_px,
            elongation=elongation,
            touches_border=touches_border,
            orientation_deg=orientation_deg,
        )

        region_body.additional_properties = d
        return region_body

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
