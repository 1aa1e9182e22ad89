from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from attrs import define as _attrs_define

from ..types import UNSET, Unset

T = TypeVar("T", bound="LocalCameraBody")


@_attrs_define
class LocalCameraBody:
    """The camera at the gripper."""

    mm_per_px: float
    """ Scale on the table. """
    rotation_deg: float | Unset = UNSET
    """ Direction of the image's x axis in the robot's plane, from X towards Y. """

    def to_dict(self) -> dict[str, Any]:
        mm_per_px = self.mm_per_px

        rotation_deg = self.rotation_deg

        field_dict: dict[str, Any] = {}

        field_dict.update(
            {
                "mm_per_px": mm_per_px,
            }
        )
        if rotation_deg is not UNSET:
            field_dict["rotation_deg"] = rotation_deg

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        mm_per_px = d.pop("mm_per_px")

        rotation_deg = d.pop("rotation_deg", UNSET)

        local_camera_body = cls(
            mm_per_px=mm_per_px,
            rotation_deg=rotation_deg,
        )

        return local_camera_body
