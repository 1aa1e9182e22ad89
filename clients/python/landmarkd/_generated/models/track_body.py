from __future__ import annotations

import datetime
from collections.abc import Mapping
from typing import Any, TypeVar, cast
from uuid import UUID

from attrs import define as _attrs_define
from attrs import field as _attrs_field
from dateutil.parser import isoparse

from ..models.motion_word import MotionWord, check_motion_word

T = TypeVar("T", bound="TrackBody")


@_attrs_define
class TrackBody:
    """A track."""

    id: UUID
    database: str
    alias: str
    """ The alias whose version answers. """
    motion: MotionWord
    """ How robots move among the exemplars. """
    version: int
    """ The version that answered last. """
    frames: int
    """ Frames that were counted. """
    warnings: list[str]
    """ `order_unknown`: `path` was asked for, but the version has exemplars that came with an artifact file or were
    deleted from the database, so that their order isn't known. """
    created_at: datetime.datetime
    expires_at: datetime.datetime
    """ When it is gone unless another frame comes. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        id = str(self.id)

        database = self.database

        alias = self.alias

        motion: str = self.motion

        version = self.version

        frames = self.frames

        warnings = self.warnings

        created_at = self.created_at.isoformat()

        expires_at = self.expires_at.isoformat()

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "id": id,
                "database": database,
                "alias": alias,
                "motion": motion,
                "version": version,
                "frames": frames,
                "warnings": warnings,
                "created_at": created_at,
                "expires_at": expires_at,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        id = UUID(d.pop("id"))

        database = d.pop("database")

        alias = d.pop("alias")

        motion = check_motion_word(d.pop("motion"))

        version = d.pop("version")

        frames = d.pop("frames")

        warnings = cast(list[str], d.pop("warnings"))

        created_at = isoparse(d.pop("created_at"))

        expires_at = isoparse(d.pop("expires_at"))

        track_body = cls(
            id=id,
            database=database,
            alias=alias,
            motion=motion,
            version=version,
            frames=frames,
            warnings=warnings,
            created_at=created_at,
            expires_at=expires_at,
        )

        track_body.additional_properties = d
        return track_body

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
