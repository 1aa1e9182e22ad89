from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from ..types import UNSET, Unset

T = TypeVar("T", bound="PoseBody")


@_attrs_define
class PoseBody:
    """How an object is turned."""

    turn_deg: float
    """ Turn about the vertical, in [0, 360). """
    sigma_deg: float
    """ Standard deviation to be expected. """
    reliable: bool
    """ Whether the pose may be acted on. """
    alternative_deg: float | None | Unset = UNSET
    """ Another pose that would look the same. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        turn_deg = self.turn_deg

        sigma_deg = self.sigma_deg

        reliable = self.reliable

        alternative_deg: float | None | Unset
        if isinstance(self.alternative_deg, Unset):
            alternative_deg = UNSET
        else:
            alternative_deg = self.alternative_deg

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "turn_deg": turn_deg,
                "sigma_deg": sigma_deg,
                "reliable": reliable,
            }
        )
        if alternative_deg is not UNSET:
            field_dict["alternative_deg"] = alternative_deg

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        turn_deg = d.pop("turn_deg")

        sigma_deg = d.pop("sigma_deg")

        reliable = d.pop("reliable")

        def _parse_alternative_deg(data: object) -> float | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(float | None | Unset, data)

        alternative_deg = _parse_alternative_deg(d.pop("alternative_deg", UNSET))

        pose_body = cls(
            turn_deg=turn_deg,
            sigma_deg=sigma_deg,
            reliable=reliable,
            alternative_deg=alternative_deg,
        )

        pose_body.additional_properties = d
        return pose_body

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
