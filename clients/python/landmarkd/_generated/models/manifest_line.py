from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, cast

from attrs import define as _attrs_define

from ..types import UNSET, Unset

T = TypeVar("T", bound="ManifestLine")


@_attrs_define
class ManifestLine:
    """One line of a batch's manifest."""

    file: str
    """ Name of the file part. """
    label: str
    """ The place or object. """
    pose_deg: float | None | Unset = UNSET
    """ Turntable pose, in degrees. """

    def to_dict(self) -> dict[str, Any]:
        file = self.file

        label = self.label

        pose_deg: float | None | Unset
        if isinstance(self.pose_deg, Unset):
            pose_deg = UNSET
        else:
            pose_deg = self.pose_deg

        field_dict: dict[str, Any] = {}

        field_dict.update(
            {
                "file": file,
                "label": label,
            }
        )
        if pose_deg is not UNSET:
            field_dict["pose_deg"] = pose_deg

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        file = d.pop("file")

        label = d.pop("label")

        def _parse_pose_deg(data: object) -> float | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(float | None | Unset, data)

        pose_deg = _parse_pose_deg(d.pop("pose_deg", UNSET))

        manifest_line = cls(
            file=file,
            label=label,
            pose_deg=pose_deg,
        )

        return manifest_line
