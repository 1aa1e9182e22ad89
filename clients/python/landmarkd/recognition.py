"""What a frame shows, and the evidence for it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from ._generated.models import (
    CandidateBody,
    DecisionBody,
    InstanceBody,
    LandmarkRecognitionBody,
    LandmarkTrackedFrameBody,
    ObjectRecognitionBody,
    ObjectTrackedFrameBody,
    PointBody,
    PoseBody,
    VoteBody,
)
from .absent import given
from .pose import PlacePose

Body = LandmarkRecognitionBody | ObjectRecognitionBody | LandmarkTrackedFrameBody | ObjectTrackedFrameBody


@dataclass(frozen=True)
class Decision:
    """What to act on."""

    label: str
    confidence: float | None
    """Probability of being right; `None` while the version isn't calibrated."""

    @classmethod
    def of(cls, body: DecisionBody) -> Decision:
        """From the service's answer."""
        return cls(body.label, given(body.confidence))


@dataclass(frozen=True)
class Recognition:
    """What a frame shows. Act on `decision`; the rest is the evidence, given in any case."""

    database: str
    kind: str
    """`landmarks` or `objects`."""
    version: int
    """The version that answered."""
    digest: str
    """Its digest: the same frame and digest give the same answer."""
    decision: Decision | None
    """`None` when nothing is recognised for sure enough, which is an answer too."""
    warnings: list[str]
    """Reasons to doubt the answer."""
    timings_ms: dict[str, float]
    """How long the parts of it took, in milliseconds."""
    frame_id: str | None = None
    """As it was sent."""
    stamp: str | None = None
    """As it was sent."""
    votes: list[VoteBody] = field(default_factory=list)
    """Landmarks: the labels voted for, best first, with their placements in pixels of the frame."""
    instances: list[InstanceBody] = field(default_factory=list)
    """Landmarks: everything known that is in the frame for sure enough."""
    points_used: int = 0
    """Landmarks: interest points that voted."""
    points_found: int = 0
    """Landmarks: interest points in the frame."""
    points: list[PointBody] | None = None
    """Landmarks, with `explain`: every point's vote."""
    candidates: list[CandidateBody] = field(default_factory=list)
    """Objects: those compared in their own eigenspaces, the likeliest first."""
    pose: PoseBody | PlacePose | None = None
    """Objects: how it is turned, in degrees; act on it if `reliable`. Landmarks whose exemplars have poses: where the
    camera is in the map."""

    @classmethod
    def of(cls, body: Body) -> Recognition:
        """From the service's answer."""
        return cls(**fields(body))


def decision(body: DecisionBody | None) -> Decision | None:
    """From the service's answer."""
    return None if body is None else Decision.of(body)


def fields(body: Body) -> dict[str, Any]:
    """The fields of a recognition that an answer has, by the kind of its database."""
    common: dict[str, Any] = {
        "database": body.database,
        "kind": body.kind,
        "version": body.version,
        "digest": body.digest,
        "decision": decision(given(body.decision)),
        "warnings": list(body.warnings),
        "timings_ms": body.timings_ms.to_dict(),
        "frame_id": given(body.header.frame_id),
        "stamp": given(body.header.stamp),
    }
    if isinstance(body, (LandmarkRecognitionBody, LandmarkTrackedFrameBody)):
        return common | {
            "votes": body.votes,
            "instances": body.instances,
            "points_used": body.points_used,
            "points_found": body.points_found,
            "points": given(body.points),
            "pose": place_pose(body),
        }
    return common | {"candidates": body.candidates, "pose": given(body.pose)}


def place_pose(body: LandmarkRecognitionBody | LandmarkTrackedFrameBody) -> PlacePose | None:
    """Where the camera is; `None` if the exemplars have no poses or the frame doesn't tell."""
    pose = body.to_dict().get("pose")
    return None if pose is None else PlacePose.of(pose)
