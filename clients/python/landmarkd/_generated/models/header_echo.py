from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from ..types import UNSET, Unset

T = TypeVar("T", bound="HeaderEcho")


@_attrs_define
class HeaderEcho:
    """What the robot says about its frame, as an answer echoes it."""

    robot_id: None | str | Unset = UNSET
    """ `X-Robot-Id` as sent. """
    frame_id: None | str | Unset = UNSET
    """ `X-Frame-Id` as sent. """
    stamp: None | str | Unset = UNSET
    """ `X-Stamp` as sent: RFC 3339 or `sec.nanosec`. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        robot_id: None | str | Unset
        if isinstance(self.robot_id, Unset):
            robot_id = UNSET
        else:
            robot_id = self.robot_id

        frame_id: None | str | Unset
        if isinstance(self.frame_id, Unset):
            frame_id = UNSET
        else:
            frame_id = self.frame_id

        stamp: None | str | Unset
        if isinstance(self.stamp, Unset):
            stamp = UNSET
        else:
            stamp = self.stamp

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update({})
        if robot_id is not UNSET:
            field_dict["robot_id"] = robot_id
        if frame_id is not UNSET:
            field_dict["frame_id"] = frame_id
        if stamp is not UNSET:
            field_dict["stamp"] = stamp

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)

        def _parse_robot_id(data: object) -> None | str | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(None | str | Unset, data)

        robot_id = _parse_robot_id(d.pop("robot_id", UNSET))

        def _parse_frame_id(data: object) -> None | str | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(None | str | Unset, data)

        frame_id = _parse_frame_id(d.pop("frame_id", UNSET))

        def _parse_stamp(data: object) -> None | str | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(None | str | Unset, data)

        stamp = _parse_stamp(d.pop("stamp", UNSET))

        header_echo = cls(
            robot_id=robot_id,
            frame_id=frame_id,
            stamp=stamp,
        )

        header_echo.additional_properties = d
        return header_echo

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
