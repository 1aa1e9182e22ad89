from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from ..models.landmark_recognition_body_kind import (
    LandmarkRecognitionBodyKind,
    check_landmark_recognition_body_kind,
)
from ..types import UNSET, Unset

if TYPE_CHECKING:
    from ..models.decision_body import DecisionBody
    from ..models.header_echo import HeaderEcho
    from ..models.instance_body import InstanceBody
    from ..models.landmark_timings_body import LandmarkTimingsBody
    from ..models.point_body import PointBody
    from ..models.vote_body import VoteBody


T = TypeVar("T", bound="LandmarkRecognitionBody")


@_attrs_define
class LandmarkRecognitionBody:
    """What a frame shows."""

    votes: list[VoteBody]
    """ The evidence, best first. """
    instances: list[InstanceBody]
    """ Everything known that is in the frame for sure enough, surest first: several things, or one several times.
    Empty
    where answers have no confidence, or no placement. """
    points_used: int
    """ Interest points that were asked: no more than it takes. """
    points_found: int
    """ Interest points in the frame. """
    database: str
    kind: LandmarkRecognitionBodyKind
    version: int
    """ The version that answered. """
    digest: str
    """ Its digest: the same frame and digest give the same answer. """
    header: HeaderEcho
    """ What the robot says about its frame, as an answer echoes it. """
    warnings: list[str]
    """ Reasons to doubt the answer. Landmarks: `no_interest_points`, `too_few_points`, `votes_on_background`,
    `close_second`, `gray_frame`. Objects: `resized`, `blank_picture`, `over_exposed`, `beyond_threshold`,
    `close_second`, `not_calibrated`; with `segment` also `no_region`, `touches_border`, `several_regions`. """
    timings_ms: LandmarkTimingsBody
    """ How long the parts of a recognition took, in milliseconds. """
    points: list[PointBody] | None | Unset = UNSET
    """ With `explain`: every point's vote, most salient first. For each label the weights sum to its W. """
    decision: DecisionBody | None | Unset = UNSET
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        from ..models.decision_body import DecisionBody

        votes = []
        for votes_item_data in self.votes:
            votes_item = votes_item_data.to_dict()
            votes.append(votes_item)

        instances = []
        for instances_item_data in self.instances:
            instances_item = instances_item_data.to_dict()
            instances.append(instances_item)

        points_used = self.points_used

        points_found = self.points_found

        database = self.database

        kind: str = self.kind

        version = self.version

        digest = self.digest

        header = self.header.to_dict()

        warnings = self.warnings

        timings_ms = self.timings_ms.to_dict()

        points: list[dict[str, Any]] | None | Unset
        if isinstance(self.points, Unset):
            points = UNSET
        elif isinstance(self.points, list):
            points = []
            for points_type_0_item_data in self.points:
                points_type_0_item = points_type_0_item_data.to_dict()
                points.append(points_type_0_item)

        else:
            points = self.points

        decision: dict[str, Any] | None | Unset
        if isinstance(self.decision, Unset):
            decision = UNSET
        elif isinstance(self.decision, DecisionBody):
            decision = self.decision.to_dict()
        else:
            decision = self.decision

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "votes": votes,
                "instances": instances,
                "points_used": points_used,
                "points_found": points_found,
                "database": database,
                "kind": kind,
                "version": version,
                "digest": digest,
                "header": header,
                "warnings": warnings,
                "timings_ms": timings_ms,
            }
        )
        if points is not UNSET:
            field_dict["points"] = points
        if decision is not UNSET:
            field_dict["decision"] = decision

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.decision_body import DecisionBody
        from ..models.header_echo import HeaderEcho
        from ..models.instance_body import InstanceBody
        from ..models.landmark_timings_body import LandmarkTimingsBody
        from ..models.point_body import PointBody
        from ..models.vote_body import VoteBody

        d = dict(src_dict)
        votes = []
        _votes = d.pop("votes")
        for votes_item_data in _votes:
            votes_item = VoteBody.from_dict(votes_item_data)

            votes.append(votes_item)

        instances = []
        _instances = d.pop("instances")
        for instances_item_data in _instances:
            instances_item = InstanceBody.from_dict(instances_item_data)

            instances.append(instances_item)

        points_used = d.pop("points_used")

        points_found = d.pop("points_found")

        database = d.pop("database")

        kind = check_landmark_recognition_body_kind(d.pop("kind"))

        version = d.pop("version")

        digest = d.pop("digest")

        header = HeaderEcho.from_dict(d.pop("header"))

        warnings = cast(list[str], d.pop("warnings"))

        timings_ms = LandmarkTimingsBody.from_dict(d.pop("timings_ms"))

        def _parse_points(data: object) -> list[PointBody] | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, list):
                    raise TypeError()
                points_type_0 = []
                _points_type_0 = data
                for points_type_0_item_data in _points_type_0:
                    points_type_0_item = PointBody.from_dict(points_type_0_item_data)

                    points_type_0.append(points_type_0_item)

                return points_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(list[PointBody] | None | Unset, data)

        points = _parse_points(d.pop("points", UNSET))

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

        landmark_recognition_body = cls(
            votes=votes,
            instances=instances,
            points_used=points_used,
            points_found=points_found,
            database=database,
            kind=kind,
            version=version,
            digest=digest,
            header=header,
            warnings=warnings,
            timings_ms=timings_ms,
            points=points,
            decision=decision,
        )

        landmark_recognition_body.additional_properties = d
        return landmark_recognition_body

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
