"""Answers as messages.

Of `vision_msgs` 4 (Humble and later). Boxes are in pixels of the image, x right and y down, the origin at the centre of
the top-left pixel; `theta` turns x towards y, clockwise as seen. A score is a probability, NaN while the version isn't
calibrated.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped
from vision_msgs.msg import (
    BoundingBox2D,
    Classification,
    Detection2D,
    Detection2DArray,
    ObjectHypothesis,
    ObjectHypothesisWithPose,
)

from landmarkd import Decision, LandmarkPose, Recognition
from landmarkd.planar import Planar
from landmarkd.sighting import Sighting


def detections(answer: Recognition, header: Any, width_px: int, height_px: int) -> Detection2DArray:
    """Everything known that is in a frame: where the exemplars lie on it, or for objects the whole frame."""
    found = Detection2DArray()
    found.header = header
    for instance in answer.instances:
        placement = instance.placement
        box = surrounding(placement.outline_px, math.radians(placement.rotation_deg))
        seen = detection(header, instance.label, instance.confidence, box)
        pose = LandmarkPose.of(placement)
        if pose is not None:
            lay(seen.results[0].pose, pose)
        found.detections.append(seen)
    if not answer.instances and answer.kind == "objects" and answer.decision:
        box = BoundingBox2D()
        box.center.position.x, box.center.position.y = (width_px - 1) / 2, (height_px - 1) / 2
        box.size_x, box.size_y = float(width_px), float(height_px)
        found.detections.append(detection(header, answer.decision.label, answer.decision.confidence, box))
    return found


def surrounding(outline_px: Any, theta: float) -> BoundingBox2D:
    """The smallest box turned by `theta` around an outline, which perspective makes any quadrilateral."""
    axes = np.array([[math.cos(theta), math.sin(theta)], [-math.sin(theta), math.cos(theta)]])
    along = np.asarray(outline_px, float) @ axes.T
    least, most = along.min(axis=0), along.max(axis=0)
    middle = (least + most) / 2 @ axes
    box = BoundingBox2D()
    box.center.position.x, box.center.position.y = map(float, middle)
    box.center.theta = theta
    box.size_x, box.size_y = map(float, most - least)
    return box


def detection(header: Any, label: str, confidence: float | None, box: BoundingBox2D) -> Detection2D:
    """One thing at one place."""
    result = ObjectHypothesisWithPose()
    result.hypothesis = hypothesis(label, confidence)
    made = Detection2D()
    made.header, made.results, made.bbox, made.id = header, [result], box, label
    return made


def lay(into: Any, pose: LandmarkPose) -> None:
    """Set a `geometry_msgs/PoseWithCovariance` to where a landmark is before the camera, in the image's frame."""
    position, turn = into.pose.position, into.pose.orientation
    position.x, position.y, position.z = pose.translation_m
    turn.x, turn.y, turn.z, turn.w = pose.quaternion
    if pose.covariance is not None:
        into.covariance = np.array(pose.covariance)


def classification(decision: Decision | None, header: Any) -> Classification:
    """What to act on; no results when nothing is decided."""
    return classified(header, [] if decision is None else [hypothesis(decision.label, decision.confidence)])


def belief(sighting: Sighting, header: Any) -> Classification:
    """Where the robot is: every likely place with its probability; what is missing to 1 is elsewhere or unlikely."""
    return classified(header, [hypothesis(each.label, each.probability) for each in sighting.belief])


def classified(header: Any, results: list[ObjectHypothesis]) -> Classification:
    """Hypotheses about an image."""
    made = Classification()
    made.header, made.results = header, results
    return made


def hypothesis(label: str, confidence: float | None) -> ObjectHypothesis:
    """A label and how sure it is."""
    made = ObjectHypothesis()
    made.class_id, made.score = label, math.nan if confidence is None else float(confidence)
    return made


def pose_stamped(
    pose: Planar, covariance: npt.NDArray[np.float64], frame: str, stamp: Any
) -> PoseWithCovarianceStamped:
    """A pose in the plane with the covariance of x, y and yaw; z, roll and pitch are taken to be 0, as AMCL does."""
    made = PoseWithCovarianceStamped()
    made.header.frame_id, made.header.stamp = frame, stamp
    position = made.pose.pose.position
    position.x, position.y = pose.x_m, pose.y_m
    turn(made.pose.pose.orientation, pose.yaw)
    whole = np.zeros((6, 6))
    # Of x, y, z and the turns about x, y, z.
    whole[np.ix_((0, 1, 5), (0, 1, 5))] = covariance
    made.pose.covariance = whole.ravel()
    return made


def transform_stamped(pose: Planar, frame: str, child: str, stamp: Any) -> TransformStamped:
    """`T_frame_child` in the plane."""
    made = TransformStamped()
    made.header.frame_id, made.header.stamp, made.child_frame_id = frame, stamp, child
    made.transform.translation.x, made.transform.translation.y = pose.x_m, pose.y_m
    turn(made.transform.rotation, pose.yaw)
    return made


def turn(quaternion: Any, yaw: float) -> None:
    """Set a `geometry_msgs/Quaternion` to a turn about z, in radians."""
    quaternion.z, quaternion.w = math.sin(yaw / 2), math.cos(yaw / 2)
