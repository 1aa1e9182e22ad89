from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from ..types import UNSET, Unset

T = TypeVar("T", bound="ConfusionBody")


@_attrs_define
class ConfusionBody:
    """Left-out views of one object that were given one wrong answer."""

    shown: str
    """ The object shown. """
    times: int
    named: None | str | Unset = UNSET
    """ The object named; null when none was. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        shown = self.shown

        times = self.times

        named: None | str | Unset
        if isinstance(self.named, Unset):
            named = UNSET
        else:
            named = self.named

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "shown": shown,
                "times": times,
            }
        )
        if named is not UNSET:
            field_dict["named"] = named

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        shown = d.pop("shown")

        times = d.pop("times")

        def _parse_named(data: object) -> None | str | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(None | str | Unset, data)

        named = _parse_named(d.pop("named", UNSET))

        confusion_body = cls(
            shown=shown,
            times=times,
            named=named,
        )

        confusion_body.additional_properties = d
        return confusion_body

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
