from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from attrs import define as _attrs_define
from attrs import field as _attrs_field

T = TypeVar("T", bound="NoiseBody")


@_attrs_define
class NoiseBody:
    """Noise of a pixel: variance = read_sigma² + shot_gain · level, in grey levels of 255."""

    read_sigma: float
    shot_gain: float
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        read_sigma = self.read_sigma

        shot_gain = self.shot_gain

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "read_sigma": read_sigma,
                "shot_gain": shot_gain,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        read_sigma = d.pop("read_sigma")

        shot_gain = d.pop("shot_gain")

        noise_body = cls(
            read_sigma=read_sigma,
            shot_gain=shot_gain,
        )

        noise_body.additional_properties = d
        return noise_body

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
