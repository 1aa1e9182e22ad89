from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from ..types import UNSET, Unset

if TYPE_CHECKING:
    from ..models.reliability_body import ReliabilityBody
    from ..models.training_timings import TrainingTimings


T = TypeVar("T", bound="LandmarkReportBody")


@_attrs_define
class LandmarkReportBody:
    """What the training of a landmark database told of itself."""

    spectrum: list[float]
    """ Variance along each direction of the signatures' space, descending, all of them. """
    energy_kept: float
    """ Part of the variance that the kept dimensions hold. """
    dimension: int
    """ Dimensions kept. """
    signature_length: int
    """ Components of a signature. """
    colour: str
    """ The planes that signatures were taken from. """
    exemplars_without_points: list[str]
    """ Exemplars in which nothing drew attention: they can't be recognised. """
    warnings: list[str]
    """ What the training has to say: `not_calibrated` if no exemplar was recognised when it was seen otherwise, so
    that
    answers have no confidence. """
    reliability: None | ReliabilityBody | Unset = UNSET
    timings_ms: None | TrainingTimings | Unset = UNSET
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        from ..models.reliability_body import ReliabilityBody
        from ..models.training_timings import TrainingTimings

        spectrum = self.spectrum

        energy_kept = self.energy_kept

        dimension = self.dimension

        signature_length = self.signature_length

        colour = self.colour

        exemplars_without_points = self.exemplars_without_points

        warnings = self.warnings

        reliability: dict[str, Any] | None | Unset
        if isinstance(self.reliability, Unset):
            reliability = UNSET
        elif isinstance(self.reliability, ReliabilityBody):
            reliability = self.reliability.to_dict()
        else:
            reliability = self.reliability

        timings_ms: dict[str, Any] | None | Unset
        if isinstance(self.timings_ms, Unset):
            timings_ms = UNSET
        elif isinstance(self.timings_ms, TrainingTimings):
            timings_ms = self.timings_ms.to_dict()
        else:
            timings_ms = self.timings_ms

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "spectrum": spectrum,
                "energy_kept": energy_kept,
                "dimension": dimension,
                "signature_length": signature_length,
                "colour": colour,
                "exemplars_without_points": exemplars_without_points,
                "warnings": warnings,
            }
        )
        if reliability is not UNSET:
            field_dict["reliability"] = reliability
        if timings_ms is not UNSET:
            field_dict["timings_ms"] = timings_ms

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.reliability_body import ReliabilityBody
        from ..models.training_timings import TrainingTimings

        d = dict(src_dict)
        spectrum = cast(list[float], d.pop("spectrum"))

        energy_kept = d.pop("energy_kept")

        dimension = d.pop("dimension")

        signature_length = d.pop("signature_length")

        colour = d.pop("colour")

        exemplars_without_points = cast(list[str], d.pop("exemplars_without_points"))

        warnings = cast(list[str], d.pop("warnings"))

        def _parse_reliability(data: object) -> None | ReliabilityBody | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                reliability_type_0 = ReliabilityBody.from_dict(data)

                return reliability_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(None | ReliabilityBody | Unset, data)

        reliability = _parse_reliability(d.pop("reliability", UNSET))

        def _parse_timings_ms(data: object) -> None | TrainingTimings | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                timings_ms_type_0 = TrainingTimings.from_dict(data)

                return timings_ms_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(None | TrainingTimings | Unset, data)

        timings_ms = _parse_timings_ms(d.pop("timings_ms", UNSET))

        landmark_report_body = cls(
            spectrum=spectrum,
            energy_kept=energy_kept,
            dimension=dimension,
            signature_length=signature_length,
            colour=colour,
            exemplars_without_points=exemplars_without_points,
            warnings=warnings,
            reliability=reliability,
            timings_ms=timings_ms,
        )

        landmark_report_body.additional_properties = d
        return landmark_report_body

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
