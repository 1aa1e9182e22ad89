"""The node with stand-ins of ROS, against the real service."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

import httpx
import numpy as np
import pytest
import ros
from drawing import blurred, moved, room, texture
from service import Service

from landmarkd import Client


@pytest.fixture
def node(service: Service, home: str, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """A node that asks the service."""
    optics = {
        "focal_length_mm": 35,
        "f_number": 8,
        "near_focus_mm": 500,
        "plane_separation_mm": 0.4,
        "pixel_pitch_um": 10,
        "telecentric": True,
    }
    httpx.put(f"{service.url}/v1/calibrations/rig", json=optics).raise_for_status()
    ros.install()
    from landmarkd_ros.node import LandmarkdNode

    parameters = {"service": service.url, "database": home, "calibration": "rig", "motion": "still"}
    monkeypatch.setattr(ros.Node, "parameters", parameters)
    running = LandmarkdNode()
    yield running
    running.destroy_node()


def taken(array: np.ndarray, seconds: int) -> Any:
    message = ros.image(array, "mono8")
    message.header.frame_id = "camera_optical_frame"
    message.header.stamp.sec = seconds
    return message


def test_places_are_published(node: Any) -> None:
    for number in range(3):
        node.detections.came.clear()
        node.subscriptions["image"](taken(moved(room(1), number, 0), number + 1))
        assert node.detections.came.wait(10), node.log
    place, decision, detections = (node.publishers[name].published[-1] for name in ("place", "decision", "detections"))
    assert place.results[0].class_id == decision.results[0].class_id == "stairs"
    assert place.header.frame_id == "camera_optical_frame"
    assert place.header.stamp.sec == 3
    assert detections.detections[0].results[0].hypothesis.class_id == "stairs"
    box = detections.detections[0].bbox
    assert (box.size_x, box.size_y) == (pytest.approx(160, abs=8), pytest.approx(160, abs=8))


def test_distances_are_published_in_metres(node: Any, client: Client) -> None:
    plane = texture(1)
    near, far = blurred(plane, 1.2), blurred(plane, 1.0)
    info = ros.CameraInfo()
    info.width = 160
    node.subscriptions["near/camera_info"](info)
    assert node.pair.topics == ["near", "far"]
    node.pair.give(taken(near, 7), taken(far, 7))
    assert node.depth_info.came.wait(10), node.log
    image = node.depth.published[0]
    metres = np.frombuffer(image.data, np.float32).reshape(image.height, image.width)
    depth = client.depth(near, far, calibration="rig")
    assert np.array_equal(metres, depth.depth_mm / np.float32(1000), equal_nan=True)
    assert (image.encoding, image.header.stamp.sec) == ("32FC1", 7)
    assert (node.depth_info.published[0].width, node.depth_info.published[0].header.stamp.sec) == (160, 7)


def test_an_encoding_that_is_not_read_is_logged(node: Any) -> None:
    message = taken(room(0), 1)
    message.encoding = "bayer_rggb8"
    node.subscriptions["image"](message)
    for _ in range(100):
        if node.log:
            break
        time.sleep(0.05)
    assert "bayer_rggb8" in node.log[0]
