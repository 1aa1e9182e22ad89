from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from attrs import define as _attrs_define
from attrs import field as _attrs_field

T = TypeVar("T", bound="PhotometricBody")


@_attrs_define
class PhotometricBody:
    """Offsets and gain of the two sensors, in grey levels of 255."""

    dark_near: float
    dark_far: float
    gain_far: float
    """ What the far-focused picture, without its dark level, is multiplied by. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        dark_near = self.dark_near

        dark_far = self.dark_far

        gain_far = self.gain_far

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "dark_near": dark_near,
                "dark_far": dark_far,
                "gain_far": gain_far,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        dark_near = d.pop("dark_near")

        dark_far = d.pop("dark_far")

        gain_far = d.pop("gain_far")

        photometric_body = cls(
            dark_near=dark_near,
            dark_far=dark_far,
            gain_far=gain_far,
        )

        photometric_body.additional_properties = d
        return photometric_body

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
