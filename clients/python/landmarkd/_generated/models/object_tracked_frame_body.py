from __future__ import annotations

import datetime
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast
from uuid import UUID

from attrs import define as _attrs_define
from attrs import field as _attrs_field
from dateutil.parser import isoparse

from ..models.motion_word import MotionWord, check_motion_word
from ..models.object_recognition_body_kind import (
    ObjectRecognitionBodyKind,
    check_object_recognition_body_kind,
)
from ..types import UNSET, Unset

if TYPE_CHECKING:
    from ..models.candidate_body import CandidateBody
    from ..models.decision_body import DecisionBody
    from ..models.frame_body import FrameBody
    from ..models.header_echo import HeaderEcho
    from ..models.label_belief_body import LabelBeliefBody
    from ..models.object_timings_body import ObjectTimingsBody
    from ..models.pose_body import PoseBody


T = TypeVar("T", bound="ObjectTrackedFrameBody")


@_attrs_define
class ObjectTrackedFrameBody:
    """What a frame shows, and where the robot is by all its frames so far. The fields are those of a recognition of this
    frame alone, but for `decision`, which is the track's.

    """

    candidates: list[CandidateBody]
    """ The objects that were looked at closely, the likeliest first. """
    database: str
    kind: ObjectRecognitionBodyKind
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
    timings_ms: ObjectTimingsBody
    """ How long the parts of a recognition took, in milliseconds. """
    track: UUID
    """ Id of the track. """
    belief: list[LabelBeliefBody]
    """ The likeliest labels, best first. """
    elsewhere: float
    """ Probability of being where no exemplar was taken. """
    frame: FrameBody
    """ A frame of a track. """
    motion: MotionWord
    """ How robots move among the exemplars. """
    expires_at: datetime.datetime
    """ When the track is gone unless another frame comes. """
    pose: None | PoseBody | Unset = UNSET
    decision: DecisionBody | None | Unset = UNSET
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        from ..models.decision_body import DecisionBody
        from ..models.pose_body import PoseBody

        candidates = []
        for candidates_item_data in self.candidates:
            candidates_item = candidates_item_data.to_dict()
            candidates.append(candidates_item)

        database = self.database

        kind: str = self.kind

        version = self.version

        digest = self.digest

        header = self.header.to_dict()

        warnings = self.warnings

        timings_ms = self.timings_ms.to_dict()

        track = str(self.track)

        belief = []
        for belief_item_data in self.belief:
            belief_item = belief_item_data.to_dict()
            belief.append(belief_item)

        elsewhere = self.elsewhere

        frame = self.frame.to_dict()

        motion: str = self.motion

        expires_at = self.expires_at.isoformat()

        pose: dict[str, Any] | None | Unset
        if isinstance(self.pose, Unset):
            pose = UNSET
        elif isinstance(self.pose, PoseBody):
            pose = self.pose.to_dict()
        else:
            pose = self.pose

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
                "candidates": candidates,
                "database": database,
                "kind": kind,
                "version": version,
                "digest": digest,
                "header": header,
                "warnings": warnings,
                "timings_ms": timings_ms,
                "track": track,
                "belief": belief,
                "elsewhere": elsewhere,
                "frame": frame,
                "motion": motion,
                "expires_at": expires_at,
            }
        )
        if pose is not UNSET:
            field_dict["pose"] = pose
        if decision is not UNSET:
            field_dict["decision"] = decision

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.candidate_body import CandidateBody
        from ..models.decision_body import DecisionBody
        from ..models.frame_body import FrameBody
        from ..models.header_echo import HeaderEcho
        from ..models.label_belief_body import LabelBeliefBody
        from ..models.object_timings_body import ObjectTimingsBody
        from ..models.pose_body import PoseBody

        d = dict(src_dict)
        candidates = []
        _candidates = d.pop("candidates")
        for candidates_item_data in _candidates:
            candidates_item = CandidateBody.from_dict(candidates_item_data)

            candidates.append(candidates_item)

        database = d.pop("database")

        kind = check_object_recognition_body_kind(d.pop("kind"))

        version = d.pop("version")

        digest = d.pop("digest")

        header = HeaderEcho.from_dict(d.pop("header"))

        warnings = cast(list[str], d.pop("warnings"))

        timings_ms = ObjectTimingsBody.from_dict(d.pop("timings_ms"))

        track = UUID(d.pop("track"))

        belief = []
        _belief = d.pop("belief")
        for belief_item_data in _belief:
            belief_item = LabelBeliefBody.from_dict(belief_item_data)

            belief.append(belief_item)

        elsewhere = d.pop("elsewhere")

        frame = FrameBody.from_dict(d.pop("frame"))

        motion = check_motion_word(d.pop("motion"))

        expires_at = isoparse(d.pop("expires_at"))

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

        object_tracked_frame_body = cls(
            candidates=candidates,
            database=database,
            kind=kind,
            version=version,
            digest=digest,
            header=header,
            warnings=warnings,
            timings_ms=timings_ms,
            track=track,
            belief=belief,
            elsewhere=elsewhere,
            frame=frame,
            motion=motion,
            expires_at=expires_at,
            pose=pose,
            decision=decision,
        )

        object_tracked_frame_body.additional_properties = d
        return object_tracked_frame_body

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
