from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from ..types import UNSET, Unset

T = TypeVar("T", bound="TrainingTimings")


@_attrs_define
class TrainingTimings:
    """How long the parts of a training took."""

    describe: float
    """ Reading and describing the exemplars. """
    eigenspace: float
    """ Eigenspace, index and artifact. """
    rehearsal: float | None | Unset = UNSET
    """ Asking the new version about its exemplars seen otherwise; null where that isn't done. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        describe = self.describe

        eigenspace = self.eigenspace

        rehearsal: float | None | Unset
        if isinstance(self.rehearsal, Unset):
            rehearsal = UNSET
        else:
            rehearsal = self.rehearsal

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "describe": describe,
                "eigenspace": eigenspace,
            }
        )
        if rehearsal is not UNSET:
            field_dict["rehearsal"] = rehearsal

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        describe = d.pop("describe")

        eigenspace = d.pop("eigenspace")

        def _parse_rehearsal(data: object) -> float | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(float | None | Unset, data)

        rehearsal = _parse_rehearsal(d.pop("rehearsal", UNSET))

        training_timings = cls(
            describe=describe,
            eigenspace=eigenspace,
            rehearsal=rehearsal,
        )

        training_timings.additional_properties = d
        return training_timings

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
