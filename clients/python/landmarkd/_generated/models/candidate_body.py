from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from ..types import UNSET, Unset

T = TypeVar("T", bound="CandidateBody")


@_attrs_define
class CandidateBody:
    """An object that was looked at closely. Distances are between pictures of unit energy: 0 is equal, √2 nothing in
    common.

    """

    label: str
    distance_in_space: float
    """ From the nearest point of the object's curve of views, in the eigenspace. """
    distance_from_space: float
    """ What of the picture the eigenspace can't express. """
    threshold: float | None | Unset = UNSET
    """ The largest total distance √(in² + from²) that is accepted as this object; null while it isn't calibrated.
    """
    mahalanobis: float | None | Unset = UNSET
    """ By the covariance of the object's views; with `distance: "mahalanobis"` only. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        label = self.label

        distance_in_space = self.distance_in_space

        distance_from_space = self.distance_from_space

        threshold: float | None | Unset
        if isinstance(self.threshold, Unset):
            threshold = UNSET
        else:
            threshold = self.threshold

        mahalanobis: float | None | Unset
        if isinstance(self.mahalanobis, Unset):
            mahalanobis = UNSET
        else:
            mahalanobis = self.mahalanobis

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "label": label,
                "distance_in_space": distance_in_space,
                "distance_from_space": distance_from_space,
            }
        )
        if threshold is not UNSET:
            field_dict["threshold"] = threshold
        if mahalanobis is not UNSET:
            field_dict["mahalanobis"] = mahalanobis

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        label = d.pop("label")

        distance_in_space = d.pop("distance_in_space")

        distance_from_space = d.pop("distance_from_space")

        def _parse_threshold(data: object) -> float | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(float | None | Unset, data)

        threshold = _parse_threshold(d.pop("threshold", UNSET))

        def _parse_mahalanobis(data: object) -> float | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(float | None | Unset, data)

        mahalanobis = _parse_mahalanobis(d.pop("mahalanobis", UNSET))

        candidate_body = cls(
            label=label,
            distance_in_space=distance_in_space,
            distance_from_space=distance_from_space,
            threshold=threshold,
            mahalanobis=mahalanobis,
        )

        candidate_body.additional_properties = d
        return candidate_body

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
