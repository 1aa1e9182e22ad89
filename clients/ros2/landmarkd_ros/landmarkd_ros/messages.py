"""Answers as ROS's messages, without ROS: each class here has the name and the fields of a message type.

Of `vision_msgs` 4 (Humble and later). Boxes are in pixels of the image, x right and y down, the origin at the centre of
the top-left pixel; `theta` turns x towards y, clockwise as seen. A score is a probability, NaN while the version isn't
calibrated.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from typing import Any

from landmarkd import Decision, Recognition
from landmarkd.sighting import Sighting


@dataclass
class ObjectHypothesis:
    """`vision_msgs/ObjectHypothesis`."""

    class_id: str
    score: float


@dataclass
class ObjectHypothesisWithPose:
    """`vision_msgs/ObjectHypothesisWithPose`; its pose is left as it is: a picture doesn't tell one in space."""

    hypothesis: ObjectHypothesis


@dataclass
class Point2D:
    """`vision_msgs/Point2D`."""

    x: float
    y: float


@dataclass
class Pose2D:
    """`vision_msgs/Pose2D`, theta in radians."""

    position: Point2D
    theta: float = 0.0


@dataclass
class BoundingBox2D:
    """`vision_msgs/BoundingBox2D`."""

    center: Pose2D
    size_x: float
    size_y: float


@dataclass
class Detection2D:
    """`vision_msgs/Detection2D`; the header is the image's."""

    header: Any
    results: list[ObjectHypothesisWithPose]
    bbox: BoundingBox2D
    id: str = ""


@dataclass
class Detection2DArray:
    """`vision_msgs/Detection2DArray`."""

    header: Any
    detections: list[Detection2D] = field(default_factory=list)


@dataclass
class Classification:
    """`vision_msgs/Classification`."""

    header: Any
    results: list[ObjectHypothesis] = field(default_factory=list)


def detections(answer: Recognition, header: Any, width_px: int, height_px: int) -> Detection2DArray:
    """Everything known that is in a frame: where the exemplars lie on it, or for objects the whole frame."""
    found = Detection2DArray(header)
    for instance in answer.instances:
        placement = instance.placement
        corners = placement.outline_px
        centre = Point2D(float(placement.x_px), float(placement.y_px))
        box = BoundingBox2D(
            Pose2D(centre, math.radians(placement.rotation_deg)),
            math.dist(corners[0], corners[1]),
            math.dist(corners[1], corners[2]),
        )
        found.detections.append(detection(header, instance.label, instance.confidence, box))
    if not answer.instances and answer.kind == "objects" and answer.decision:
        middle = Point2D((width_px - 1) / 2, (height_px - 1) / 2)
        box = BoundingBox2D(Pose2D(middle), float(width_px), float(height_px))
        found.detections.append(detection(header, answer.decision.label, answer.decision.confidence, box))
    return found


def detection(header: Any, label: str, confidence: float | None, box: BoundingBox2D) -> Detection2D:
    """One thing at one place."""
    return Detection2D(header, [ObjectHypothesisWithPose(ObjectHypothesis(label, score(confidence)))], box)


def classification(decision: Decision | None, header: Any) -> Classification:
    """What to act on; no results when nothing is decided."""
    return Classification(
        header, [] if decision is None else [ObjectHypothesis(decision.label, score(decision.confidence))]
    )


def belief(sighting: Sighting, header: Any) -> Classification:
    """Where the robot is: every likely place with its probability; what is missing to 1 is elsewhere or unlikely."""
    return Classification(header, [ObjectHypothesis(each.label, each.probability) for each in sighting.belief])


def score(confidence: float | None) -> float:
    """A probability as a number."""
    return math.nan if confidence is None else confidence


def message(value: Any, types: Mapping[str, type]) -> Any:
    """A value of a class of this module as the message type of its name; others as they are.

    Raises:
        KeyError: there is no such type.
        AttributeError: it has no such field.

    """
    if isinstance(value, list):
        return [message(each, types) for each in value]
    if not is_dataclass(value) or type(value).__name__ not in NAMES:
        return value
    made = types[type(value).__name__]()
    for each in fields(value):
        # Not taken for granted: an unknown attribute of a message in Python would be set without a word.
        getattr(made, each.name)
        setattr(made, each.name, message(getattr(value, each.name), types))
    return made


NAMES = {
    kind.__name__
    for kind in (
        ObjectHypothesis,
        ObjectHypothesisWithPose,
        Point2D,
        Pose2D,
        BoundingBox2D,
        Detection2D,
        Detection2DArray,
        Classification,
    )
}
