from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

T = TypeVar("T", bound="TableBody")


@_attrs_define
class TableBody:
    """From what the method says to what is true, by planes at known depths."""

    beta: list[float]
    """ Where the planes are between the focus distances: 1 near, −1 far. """
    raw: list[float]
    """ What the method said. """
    sigma: list[float]
    """ Standard deviation of that over the plane. """
    depth_mm: list[float]
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        beta = self.beta

        raw = self.raw

        sigma = self.sigma

        depth_mm = self.depth_mm

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "beta": beta,
                "raw": raw,
                "sigma": sigma,
                "depth_mm": depth_mm,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        beta = cast(list[float], d.pop("beta"))

        raw = cast(list[float], d.pop("raw"))

        sigma = cast(list[float], d.pop("sigma"))

        depth_mm = cast(list[float], d.pop("depth_mm"))

        table_body = cls(
            beta=beta,
            raw=raw,
            sigma=sigma,
            depth_mm=depth_mm,
        )

        table_body.additional_properties = d
        return table_body

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
