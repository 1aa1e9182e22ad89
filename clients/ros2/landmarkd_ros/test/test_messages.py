"""Answers as messages, by the real definitions."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
import ros

from landmarkd import Decision, LabelBelief, Recognition
from landmarkd._generated.models import InstanceBody, PlacementBody
from landmarkd.planar import Planar
from landmarkd.sighting import Sighting
from landmarkd_ros import messages

HEADER = ros.stamped(ros.message_type("sensor_msgs/msg/Image")(), 7.5, "camera_optical_frame").header


def answer(**more: object) -> Recognition:
    return Recognition("home", "landmarks", 1, "d", Decision("kitchen", 0.9), [], {}, **more)


def placed(label: str, corners: list[list[float]], **more: object) -> InstanceBody:
    # Turned by 90° about (100, 50).
    placement = PlacementBody(100.0, 50.0, 90.0, 1.0, 12, 0.5, corners, "e")
    placement.additional_properties.update(more)
    return InstanceBody(label, 0.75, placement)


# 40 by 20 pixels.
UPRIGHT = [[110.0, 30.0], [110.0, 70.0], [90.0, 70.0], [90.0, 30.0]]


def sent(message: ros.Message) -> ros.Message:
    """What comes out at the other end."""
    return ros.loaded(
        ros.STORE.deserialize_cdr(ros.STORE.serialize_cdr(ros.stored(message), message.NAME), message.NAME)
    )


def test_placements_become_boxes() -> None:
    found = sent(messages.detections(answer(instances=[placed("kitchen", UPRIGHT)]), HEADER, 320, 240))
    assert (found.header.frame_id, found.header.stamp.sec, found.header.stamp.nanosec) == (
        "camera_optical_frame",
        7,
        500_000_000,
    )
    (detection,) = found.detections
    assert detection.header.frame_id == "camera_optical_frame"
    (result,) = detection.results
    assert (result.hypothesis.class_id, result.hypothesis.score) == ("kitchen", 0.75)
    box = detection.bbox
    assert (box.center.position.x, box.center.position.y) == pytest.approx((100, 50))
    assert box.center.theta == pytest.approx(math.pi / 2)
    assert (box.size_x, box.size_y) == pytest.approx((40, 20))
    # No camera was sent, so nothing is known of its pose.
    assert not result.pose.covariance.any()


def test_a_box_surrounds_what_perspective_makes_of_an_outline() -> None:
    slanted = [[110.0, 30.0], [130.0, 70.0], [80.0, 75.0], [90.0, 35.0]]
    box = messages.detections(answer(instances=[placed("kitchen", slanted)]), HEADER, 320, 240).detections[0].bbox
    assert (box.size_x, box.size_y) == pytest.approx((45, 50))
    assert (box.center.position.x, box.center.position.y) == pytest.approx((105, 52.5))


def test_a_flat_landmark_has_its_pose_before_the_camera() -> None:
    covariance = np.diag([1e-4, 1e-4, 4e-4, 1e-3, 1e-3, 1e-4])
    solution = {
        "translation_m": [0.1, -0.2, 1.5],
        "quaternion": [0.0, 0.0, 0.6, 0.8],
        "covariance": covariance.ravel().tolist(),
        "error_px": 0.4,
    }
    instance = placed("kitchen", UPRIGHT, T_camera_landmark=solution)
    pose = sent(messages.detections(answer(instances=[instance]), HEADER, 320, 240)).detections[0].results[0].pose
    assert (pose.pose.position.x, pose.pose.position.y, pose.pose.position.z) == (0.1, -0.2, 1.5)
    assert (pose.pose.orientation.z, pose.pose.orientation.w) == (0.6, 0.8)
    assert np.array_equal(pose.covariance.reshape(6, 6), covariance)


def test_an_object_is_the_whole_frame() -> None:
    seen = dataclasses.replace(answer(), kind="objects", decision=Decision("cup", None))
    (detection,) = sent(messages.detections(seen, HEADER, 64, 32)).detections
    assert (detection.bbox.size_x, detection.bbox.size_y, detection.bbox.center.position.x) == (64, 32, 31.5)
    assert math.isnan(detection.results[0].hypothesis.score)
    assert messages.detections(dataclasses.replace(seen, decision=None), HEADER, 64, 32).detections == []


def test_decisions_and_beliefs_become_classifications() -> None:
    assert sent(messages.classification(None, HEADER)).results == []
    converted = sent(messages.classification(Decision("kitchen", 0.9), HEADER))
    assert [(each.class_id, each.score) for each in converted.results] == [("kitchen", 0.9)]
    believed = [LabelBelief("kitchen", 0.7), LabelBelief("stairs", 0.2)]
    sighting = Sighting("1", "1.0", "track", 1, "d", None, believed, 0.1, None, [], 5.0, answer())
    assert [(each.class_id, each.score) for each in sent(messages.belief(sighting, HEADER)).results] == [
        ("kitchen", 0.7),
        ("stairs", 0.2),
    ]


def test_a_pose_in_the_plane_has_its_covariance_where_ros_has_it() -> None:
    covariance = np.array([[0.04, 0.01, 0.002], [0.01, 0.09, 0.003], [0.002, 0.003, 0.0004]])
    made = sent(messages.pose_stamped(Planar(1.0, -2.0, math.pi / 2), covariance, "map", HEADER.stamp))
    assert (made.header.frame_id, made.header.stamp.sec) == ("map", 7)
    turn = made.pose.pose.orientation
    assert 2 * math.atan2(turn.z, turn.w) == pytest.approx(math.pi / 2)
    whole = made.pose.covariance.reshape(6, 6)
    assert np.array_equal(whole[np.ix_((0, 1, 5), (0, 1, 5))], covariance)
    assert whole.sum() == pytest.approx(covariance.sum())


def test_the_stand_ins_refuse_what_rclpy_refuses() -> None:
    box = ros.message_type("vision_msgs/msg/BoundingBox2D")()
    with pytest.raises(AssertionError):
        box.size_x = 4
    with pytest.raises(AttributeError):
        box.width = 4.0
    with pytest.raises(AssertionError):
        ros.message_type("diagnostic_msgs/msg/DiagnosticStatus")().level = 1
    with pytest.raises(AssertionError):
        ros.message_type("geometry_msgs/msg/PoseWithCovariance")().covariance = np.zeros((6, 6), np.float32)
