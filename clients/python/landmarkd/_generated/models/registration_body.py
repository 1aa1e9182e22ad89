from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

T = TypeVar("T", bound="RegistrationBody")


@_attrs_define
class RegistrationBody:
    """How the far-focused picture is brought into register."""

    affine_far_to_near: list[float]
    """ a, b, c, d, e, f: the far pixel (a·x + b·y + c, d·x + e·y + f) shows what the near pixel (x, y) shows. """
    rms_px: float
    """ What is left between both. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        affine_far_to_near = self.affine_far_to_near

        rms_px = self.rms_px

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "affine_far_to_near": affine_far_to_near,
                "rms_px": rms_px,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        affine_far_to_near = cast(list[float], d.pop("affine_far_to_near"))

        rms_px = d.pop("rms_px")

        registration_body = cls(
            affine_far_to_near=affine_far_to_near,
            rms_px=rms_px,
        )

        registration_body.additional_properties = d
        return registration_body

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
