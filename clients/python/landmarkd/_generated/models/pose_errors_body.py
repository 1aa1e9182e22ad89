from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from attrs import define as _attrs_define
from attrs import field as _attrs_field

T = TypeVar("T", bound="PoseErrorsBody")


@_attrs_define
class PoseErrorsBody:
    """Errors of the pose of left-out views, which see twice the gap that a picture to recognise sees."""

    trials: int
    mean_deg: float
    median_deg: float
    p95_deg: float
    within_5_deg: int
    """ How many were within 5°. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        trials = self.trials

        mean_deg = self.mean_deg

        median_deg = self.median_deg

        p95_deg = self.p95_deg

        within_5_deg = self.within_5_deg

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "trials": trials,
                "mean_deg": mean_deg,
                "median_deg": median_deg,
                "p95_deg": p95_deg,
                "within_5_deg": within_5_deg,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        trials = d.pop("trials")

        mean_deg = d.pop("mean_deg")

        median_deg = d.pop("median_deg")

        p95_deg = d.pop("p95_deg")

        within_5_deg = d.pop("within_5_deg")

        pose_errors_body = cls(
            trials=trials,
            mean_deg=mean_deg,
            median_deg=median_deg,
            p95_deg=p95_deg,
            within_5_deg=within_5_deg,
        )

        pose_errors_body.additional_properties = d
        return pose_errors_body

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
