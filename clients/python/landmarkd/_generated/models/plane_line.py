from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from attrs import define as _attrs_define

T = TypeVar("T", bound="PlaneLine")


@_attrs_define
class PlaneLine:
    """One plane of a sweep."""

    depth_mm: float
    """ Distance of the plane from the lens. """
    near: str
    """ Name of the part with the near-focused picture. """
    far: str
    """ Name of the part with the far-focused picture. """

    def to_dict(self) -> dict[str, Any]:
        depth_mm = self.depth_mm

        near = self.near

        far = self.far

        field_dict: dict[str, Any] = {}

        field_dict.update(
            {
                "depth_mm": depth_mm,
                "near": near,
                "far": far,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        depth_mm = d.pop("depth_mm")

        near = d.pop("near")

        far = d.pop("far")

        plane_line = cls(
            depth_mm=depth_mm,
            near=near,
            far=far,
        )

        return plane_line
