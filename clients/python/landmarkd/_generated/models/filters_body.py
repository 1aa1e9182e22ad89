from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from ..models.depth_method_word import DepthMethodWord, check_depth_method_word

T = TypeVar("T", bound="FiltersBody")


@_attrs_define
class FiltersBody:
    """The filters that the table was measured with."""

    method: DepthMethodWord
    """ What depth is read from: `gram`, the depth that explains both pictures best; `stm`, a closed form, the
    cheapest; `laplacian`, the paper's, which needs a calibration with a sweep by this method. """
    k: int
    """ Side of the kernels. """
    j: int
    """ Pairs of kernels. """
    band: float
    """ Highest frequency that they let pass, cycles a pixel. """
    scale: int
    """ By how much the pictures are shrunk first. """
    hash_: str
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        method: str = self.method

        k = self.k

        j = self.j

        band = self.band

        scale = self.scale

        hash_ = self.hash_

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "method": method,
                "K": k,
                "J": j,
                "band": band,
                "scale": scale,
                "hash": hash_,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        method = check_depth_method_word(d.pop("method"))

        k = d.pop("K")

        j = d.pop("J")

        band = d.pop("band")

        scale = d.pop("scale")

        hash_ = d.pop("hash")

        filters_body = cls(
            method=method,
            k=k,
            j=j,
            band=band,
            scale=scale,
            hash_=hash_,
        )

        filters_body.additional_properties = d
        return filters_body

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
