from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from ..types import UNSET, Unset

T = TypeVar("T", bound="ComparisonBody")


@_attrs_define
class ComparisonBody:
    """A trained version and the one that `current` pointed to, shown the same: exemplars of the new one, seen otherwise.
    Landmarks are also shown with their label left out of either version, when the right answer is null.

    """

    trials: int
    """ How often both were asked. """
    candidate_right: int
    """ Right answers of the trained version. """
    current_right: int
    """ Right answers of the version in use. """
    candidate_only: int
    """ Asked when the trained version alone was right. """
    current_only: int
    """ Asked when the version in use alone was right. """
    p_value: float
    """ The chance that, of those on which they differ, as many or more go to the version in use if both are equally
    good (sign test). Below 0.05 the trained version counts as worse. """
    promoted: bool
    """ Whether `current` moved to the trained version. """
    against_version: int | None | Unset = UNSET
    """ The version in use; null if `current` pointed to none that loads: then nothing was shown, and it is
    promoted. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        trials = self.trials

        candidate_right = self.candidate_right

        current_right = self.current_right

        candidate_only = self.candidate_only

        current_only = self.current_only

        p_value = self.p_value

        promoted = self.promoted

        against_version: int | None | Unset
        if isinstance(self.against_version, Unset):
            against_version = UNSET
        else:
            against_version = self.against_version

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "trials": trials,
                "candidate_right": candidate_right,
                "current_right": current_right,
                "candidate_only": candidate_only,
                "current_only": current_only,
                "p_value": p_value,
                "promoted": promoted,
            }
        )
        if against_version is not UNSET:
            field_dict["against_version"] = against_version

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        trials = d.pop("trials")

        candidate_right = d.pop("candidate_right")

        current_right = d.pop("current_right")

        candidate_only = d.pop("candidate_only")

        current_only = d.pop("current_only")

        p_value = d.pop("p_value")

        promoted = d.pop("promoted")

        def _parse_against_version(data: object) -> int | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(int | None | Unset, data)

        against_version = _parse_against_version(d.pop("against_version", UNSET))

        comparison_body = cls(
            trials=trials,
            candidate_right=candidate_right,
            current_right=current_right,
            candidate_only=candidate_only,
            current_only=current_only,
            p_value=p_value,
            promoted=promoted,
            against_version=against_version,
        )

        comparison_body.additional_properties = d
        return comparison_body

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
