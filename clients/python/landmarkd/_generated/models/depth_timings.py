from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from attrs import define as _attrs_define
from attrs import field as _attrs_field

T = TypeVar("T", bound="DepthTimings")


@_attrs_define
class DepthTimings:
    """How long the parts of a depth map took, in milliseconds."""

    queue: float
    """ Waiting for a computing thread. """
    design: float
    """ Making filters ready; next to nothing when the same optics and options were used lately. """
    decode: float
    total: float
    """ All that follows decoding: the sum of the four below. """
    register: float
    """ Scale and shift. """
    match: float
    """ Brightness, and halving. """
    estimate: float
    """ Filters and windows. """
    judge: float
    """ Choice of windows, lens law, flags. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        queue = self.queue

        design = self.design

        decode = self.decode

        total = self.total

        register = self.register

        match = self.match

        estimate = self.estimate

        judge = self.judge

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "queue": queue,
                "design": design,
                "decode": decode,
                "total": total,
                "register": register,
                "match": match,
                "estimate": estimate,
                "judge": judge,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        queue = d.pop("queue")

        design = d.pop("design")

        decode = d.pop("decode")

        total = d.pop("total")

        register = d.pop("register")

        match = d.pop("match")

        estimate = d.pop("estimate")

        judge = d.pop("judge")

        depth_timings = cls(
            queue=queue,
            design=design,
            decode=decode,
            total=total,
            register=register,
            match=match,
            estimate=estimate,
            judge=judge,
        )

        depth_timings.additional_properties = d
        return depth_timings

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
