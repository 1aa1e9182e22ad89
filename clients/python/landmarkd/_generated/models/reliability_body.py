from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from attrs import define as _attrs_define
from attrs import field as _attrs_field

if TYPE_CHECKING:
    from ..models.reliability_bin_body import ReliabilityBinBody


T = TypeVar("T", bound="ReliabilityBody")


@_attrs_define
class ReliabilityBody:
    """What the version answered when its exemplars were shown turned, moved, on other ground and partly hidden: as they
    are, and again with all of their label left out, when nothing should be recognised.

    """

    known: int
    """ Frames that showed something known. """
    unknown: int
    """ Frames that showed nothing known. """
    known_named: float
    """ Part of the known ones that were decided rightly. """
    known_misnamed: float
    """ Part of the known ones that were decided wrongly. """
    unknown_refused: float
    """ Part of the unknown ones whose decision was null. """
    curve: list[ReliabilityBinBody]
    """ Of the answers of about one confidence, how many were right. Each answer's confidence is of a curve fitted
    without it. """
    threshold: float
    """ Below this confidence the decision is null. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        known = self.known

        unknown = self.unknown

        known_named = self.known_named

        known_misnamed = self.known_misnamed

        unknown_refused = self.unknown_refused

        curve = []
        for curve_item_data in self.curve:
            curve_item = curve_item_data.to_dict()
            curve.append(curve_item)

        threshold = self.threshold

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "known": known,
                "unknown": unknown,
                "known_named": known_named,
                "known_misnamed": known_misnamed,
                "unknown_refused": unknown_refused,
                "curve": curve,
                "threshold": threshold,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.reliability_bin_body import ReliabilityBinBody

        d = dict(src_dict)
        known = d.pop("known")

        unknown = d.pop("unknown")

        known_named = d.pop("known_named")

        known_misnamed = d.pop("known_misnamed")

        unknown_refused = d.pop("unknown_refused")

        curve = []
        _curve = d.pop("curve")
        for curve_item_data in _curve:
            curve_item = ReliabilityBinBody.from_dict(curve_item_data)

            curve.append(curve_item)

        threshold = d.pop("threshold")

        reliability_body = cls(
            known=known,
            unknown=unknown,
            known_named=known_named,
            known_misnamed=known_misnamed,
            unknown_refused=unknown_refused,
            curve=curve,
            threshold=threshold,
        )

        reliability_body.additional_properties = d
        return reliability_body

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
