"""Descriptions of cameras as the service takes them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import ros

from landmarkd import Camera
from landmarkd_ros import cameras


def info(model: str = "plumb_bob", d: tuple[float, ...] = (0.1, -0.2, 0.001, 0.002, 0.03)) -> Any:
    made = ros.message_type("sensor_msgs/msg/CameraInfo")()
    made.width, made.height, made.distortion_model, made.d = 640, 480, model, list(map(float, d))
    made.k = np.array([500.0, 0, 320, 0, 501, 240, 0, 0, 1])
    made.p = np.array([450.0, 0, 321, -40, 0, 450, 241, 0, 0, 0, 1, 0])
    return made


def test_matrix_and_distortion_are_taken_as_opencv_orders_them() -> None:
    assert cameras.camera(info(), False) == Camera(500, 501, 320, 240, 640, 480, 0.1, -0.2, 0.001, 0.002, 0.03)
    assert cameras.camera(info(d=(0.1, -0.2, 0.0, 0.0)), False).k3 == 0
    flat = info("rational_polynomial", (0.1, 0, 0, 0, 0, 0, 0, 0))
    assert cameras.camera(flat, False).k1 == 0.1
    assert cameras.camera(info("", ()), False) == Camera(500, 501, 320, 240, 640, 480)


def test_a_rectified_picture_has_the_projection() -> None:
    assert cameras.camera(info(), True) == Camera(450, 450, 321, 241, 640, 480)


@pytest.mark.parametrize(
    ("model", "d"), [("equidistant", (0.1, 0, 0, 0)), ("rational_polynomial", (0, 0, 0, 0, 0, 0.2))]
)
def test_another_distortion_is_refused(model: str, d: tuple[float, ...]) -> None:
    with pytest.raises(ValueError, match="rectify"):
        cameras.camera(info(model, tuple(map(float, d))), False)


def test_a_camera_that_is_not_calibrated_or_cut_is_refused() -> None:
    blank = info()
    blank.k = np.zeros(9)
    with pytest.raises(ValueError, match="calibrated"):
        cameras.camera(blank, False)
    cut = info()
    cut.roi.width = 100
    with pytest.raises(ValueError, match="region of interest"):
        cameras.camera(cut, False)
