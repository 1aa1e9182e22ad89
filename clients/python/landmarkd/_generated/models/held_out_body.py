from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from attrs import define as _attrs_define
from attrs import field as _attrs_field

T = TypeVar("T", bound="HeldOutBody")


@_attrs_define
class HeldOutBody:
    """Each view in turn was left out of its object and shown, and was shown to the other objects alone. The threshold was
    chosen on the same views: others may fare worse.

    """

    known: int
    """ Views of objects with at least two. """
    known_accepted: int
    """ Of these, accepted as something. """
    known_right: int
    """ Of these, named right. """
    unknown: int
    """ Views shown to the other objects alone. """
    unknown_refused: int
    """ Of these, refused. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        known = self.known

        known_accepted = self.known_accepted

        known_right = self.known_right

        unknown = self.unknown

        unknown_refused = self.unknown_refused

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "known": known,
                "known_accepted": known_accepted,
                "known_right": known_right,
                "unknown": unknown,
                "unknown_refused": unknown_refused,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        known = d.pop("known")

        known_accepted = d.pop("known_accepted")

        known_right = d.pop("known_right")

        unknown = d.pop("unknown")

        unknown_refused = d.pop("unknown_refused")

        held_out_body = cls(
            known=known,
            known_accepted=known_accepted,
            known_right=known_right,
            unknown=unknown,
            unknown_refused=unknown_refused,
        )

        held_out_body.additional_properties = d
        return held_out_body

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
