from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, cast

from attrs import define as _attrs_define

from ..models.motion_word import MotionWord, check_motion_word
from ..types import UNSET, Unset

T = TypeVar("T", bound="NewTrack")


@_attrs_define
class NewTrack:
    """A track to begin."""

    motion: MotionWord | Unset = UNSET
    """ How robots move among the exemplars. """
    alias: None | str | Unset = UNSET
    """ The alias whose version answers; `current` when it isn't given. """

    def to_dict(self) -> dict[str, Any]:
        motion: str | Unset = UNSET
        if not isinstance(self.motion, Unset):
            motion = self.motion

        alias: None | str | Unset
        if isinstance(self.alias, Unset):
            alias = UNSET
        else:
            alias = self.alias

        field_dict: dict[str, Any] = {}

        field_dict.update({})
        if motion is not UNSET:
            field_dict["motion"] = motion
        if alias is not UNSET:
            field_dict["alias"] = alias

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        _motion = d.pop("motion", UNSET)
        motion: MotionWord | Unset
        if isinstance(_motion, Unset):
            motion = UNSET
        else:
            motion = check_motion_word(_motion)

        def _parse_alias(data: object) -> None | str | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(None | str | Unset, data)

        alias = _parse_alias(d.pop("alias", UNSET))

        new_track = cls(
            motion=motion,
            alias=alias,
        )

        return new_track
