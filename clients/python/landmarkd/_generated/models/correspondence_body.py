from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, cast

from attrs import define as _attrs_define

T = TypeVar("T", bound="CorrespondenceBody")


@_attrs_define
class CorrespondenceBody:
    """A pixel of the overview camera and the place on the table that it shows."""

    image_px: list[float]
    """ x and y. """
    robot_mm: list[float]
    """ X and Y. """

    def to_dict(self) -> dict[str, Any]:
        image_px = self.image_px

        robot_mm = self.robot_mm

        field_dict: dict[str, Any] = {}

        field_dict.update(
            {
                "image_px": image_px,
                "robot_mm": robot_mm,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        image_px = cast(list[float], d.pop("image_px"))

        robot_mm = cast(list[float], d.pop("robot_mm"))

        correspondence_body = cls(
            image_px=image_px,
            robot_mm=robot_mm,
        )

        return correspondence_body
