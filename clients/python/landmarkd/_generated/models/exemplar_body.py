from __future__ import annotations

import datetime
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast
from uuid import UUID

from attrs import define as _attrs_define
from attrs import field as _attrs_field
from dateutil.parser import isoparse

from ..types import UNSET, Unset

if TYPE_CHECKING:
    from ..models.header_echo import HeaderEcho


T = TypeVar("T", bound="ExemplarBody")


@_attrs_define
class ExemplarBody:
    """A training image."""

    id: UUID
    label: str
    width_px: int
    height_px: int
    bytes_: int
    """ Size of the picture as sent. """
    sha256: str
    """ SHA-256 of the picture as sent. """
    media_type: str
    created_at: datetime.datetime
    header: HeaderEcho
    """ What the robot says about its frame, as an answer echoes it. """
    pose_deg: float | None | Unset = UNSET
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        id = str(self.id)

        label = self.label

        width_px = self.width_px

        height_px = self.height_px

        bytes_ = self.bytes_

        sha256 = self.sha256

        media_type = self.media_type

        created_at = self.created_at.isoformat()

        header = self.header.to_dict()

        pose_deg: float | None | Unset
        if isinstance(self.pose_deg, Unset):
            pose_deg = UNSET
        else:
            pose_deg = self.pose_deg

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "id": id,
                "label": label,
                "width_px": width_px,
                "height_px": height_px,
                "bytes": bytes_,
                "sha256": sha256,
                "media_type": media_type,
                "created_at": created_at,
                "header": header,
            }
        )
        if pose_deg is not UNSET:
            field_dict["pose_deg"] = pose_deg

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.header_echo import HeaderEcho

        d = dict(src_dict)
        id = UUID(d.pop("id"))

        label = d.pop("label")

        width_px = d.pop("width_px")

        height_px = d.pop("height_px")

        bytes_ = d.pop("bytes")

        sha256 = d.pop("sha256")

        media_type = d.pop("media_type")

        created_at = isoparse(d.pop("created_at"))

        header = HeaderEcho.from_dict(d.pop("header"))

        def _parse_pose_deg(data: object) -> float | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(float | None | Unset, data)

        pose_deg = _parse_pose_deg(d.pop("pose_deg", UNSET))

        exemplar_body = cls(
            id=id,
            label=label,
            width_px=width_px,
            height_px=height_px,
            bytes_=bytes_,
            sha256=sha256,
            media_type=media_type,
            created_at=created_at,
            header=header,
            pose_deg=pose_deg,
        )

        exemplar_body.additional_properties = d
        return exemplar_body

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
