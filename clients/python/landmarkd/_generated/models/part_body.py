from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from ..types import UNSET, Unset

if TYPE_CHECKING:
    from ..models.candidate_body import CandidateBody
    from ..models.decision_body import DecisionBody
    from ..models.pose_body import PoseBody
    from ..models.region_body import RegionBody


T = TypeVar("T", bound="PartBody")


@_attrs_define
class PartBody:
    """A part on the table."""

    region: RegionBody
    """ A connected part of a picture that stands out from its background. """
    candidates: list[CandidateBody]
    """ The objects that were looked at closely, the likeliest first. """
    warnings: list[str]
    """ Those of a recognition: `touches_border` (what is missing may change the answer), `over_exposed`,
    `blank_picture`, `beyond_threshold`, `close_second`, `not_calibrated`. `beyond_horizon`: the mapping has no
    place for it. `no_depth`: it was looked for, and no pixel of the part has one. """
    robot_mm: list[float] | None | Unset = UNSET
    """ Where its centroid is, X and Y; null beyond the horizon of the mapping. """
    robot_deg: float | None | Unset = UNSET
    """ Direction of its principal axis, in [-90, 90), from X towards Y; null if it has none. """
    decision: DecisionBody | None | Unset = UNSET
    pose: None | PoseBody | Unset = UNSET
    distance_mm: float | None | Unset = UNSET
    """ Median of the distances within its region; null if none was measured. """
    distance_sigma_mm: float | None | Unset = UNSET
    """ Standard deviation to be expected of it; null if the method tells none. """
    distance_coverage: float | None | Unset = UNSET
    """ Part of its pixels that have a distance. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        from ..models.decision_body import DecisionBody
        from ..models.pose_body import PoseBody

        region = self.region.to_dict()

        candidates = []
        for candidates_item_data in self.candidates:
            candidates_item = candidates_item_data.to_dict()
            candidates.append(candidates_item)

        warnings = self.warnings

        robot_mm: list[float] | None | Unset
        if isinstance(self.robot_mm, Unset):
            robot_mm = UNSET
        elif isinstance(self.robot_mm, list):
            robot_mm = self.robot_mm

        else:
            robot_mm = self.robot_mm

        robot_deg: float | None | Unset
        if isinstance(self.robot_deg, Unset):
            robot_deg = UNSET
        else:
            robot_deg = self.robot_deg

        decision: dict[str, Any] | None | Unset
        if isinstance(self.decision, Unset):
            decision = UNSET
        elif isinstance(self.decision, DecisionBody):
            decision = self.decision.to_dict()
        else:
            decision = self.decision

        pose: dict[str, Any] | None | Unset
        if isinstance(self.pose, Unset):
            pose = UNSET
        elif isinstance(self.pose, PoseBody):
            pose = self.pose.to_dict()
        else:
            pose = self.pose

        distance_mm: float | None | Unset
        if isinstance(self.distance_mm, Unset):
            distance_mm = UNSET
        else:
            distance_mm = self.distance_mm

        distance_sigma_mm: float | None | Unset
        if isinstance(self.distance_sigma_mm, Unset):
            distance_sigma_mm = UNSET
        else:
            distance_sigma_mm = self.distance_sigma_mm

        distance_coverage: float | None | Unset
        if isinstance(self.distance_coverage, Unset):
            distance_coverage = UNSET
        else:
            distance_coverage = self.distance_coverage

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "region": region,
                "candidates": candidates,
                "warnings": warnings,
            }
        )
        if robot_mm is not UNSET:
            field_dict["robot_mm"] = robot_mm
        if robot_deg is not UNSET:
            field_dict["robot_deg"] = robot_deg
        if decision is not UNSET:
            field_dict["decision"] = decision
        if pose is not UNSET:
            field_dict["pose"] = pose
        if distance_mm is not UNSET:
            field_dict["distance_mm"] = distance_mm
        if distance_sigma_mm is not UNSET:
            field_dict["distance_sigma_mm"] = distance_sigma_mm
        if distance_coverage is not UNSET:
            field_dict["distance_coverage"] = distance_coverage

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.candidate_body import CandidateBody
        from ..models.decision_body import DecisionBody
        from ..models.pose_body import PoseBody
        from ..models.region_body import RegionBody

        d = dict(src_dict)
        region = RegionBody.from_dict(d.pop("region"))

        candidates = []
        _candidates = d.pop("candidates")
        for candidates_item_data in _candidates:
            candidates_item = CandidateBody.from_dict(candidates_item_data)

            candidates.append(candidates_item)

        warnings = cast(list[str], d.pop("warnings"))

        def _parse_robot_mm(data: object) -> list[float] | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, list):
                    raise TypeError()
                robot_mm_type_0 = cast(list[float], data)

                return robot_mm_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(list[float] | None | Unset, data)

        robot_mm = _parse_robot_mm(d.pop("robot_mm", UNSET))

        def _parse_robot_deg(data: object) -> float | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(float | None | Unset, data)

        robot_deg = _parse_robot_deg(d.pop("robot_deg", UNSET))

        def _parse_decision(data: object) -> DecisionBody | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                decision_type_0 = DecisionBody.from_dict(data)

                return decision_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(DecisionBody | None | Unset, data)

        decision = _parse_decision(d.pop("decision", UNSET))

        def _parse_pose(data: object) -> None | PoseBody | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                pose_type_0 = PoseBody.from_dict(data)

                return pose_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(None | PoseBody | Unset, data)

        pose = _parse_pose(d.pop("pose", UNSET))

        def _parse_distance_mm(data: object) -> float | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(float | None | Unset, data)

        distance_mm = _parse_distance_mm(d.pop("distance_mm", UNSET))

        def _parse_distance_sigma_mm(data: object) -> float | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(float | None | Unset, data)

        distance_sigma_mm = _parse_distance_sigma_mm(d.pop("distance_sigma_mm", UNSET))

        def _parse_distance_coverage(data: object) -> float | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(float | None | Unset, data)

        distance_coverage = _parse_distance_coverage(d.pop("distance_coverage", UNSET))

        part_body = cls(
            region=region,
            candidates=candidates,
            warnings=warnings,
            robot_mm=robot_mm,
            robot_deg=robot_deg,
            decision=decision,
            pose=pose,
            distance_mm=distance_mm,
            distance_sigma_mm=distance_sigma_mm,
            distance_coverage=distance_coverage,
        )

        part_body.additional_properties = d
        return part_body

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
