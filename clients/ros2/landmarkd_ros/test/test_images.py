"""Images of ROS as arrays, and distances as images of ROS."""

from __future__ import annotations

import math

import numpy as np
import pytest
import ros

from landmarkd_ros import images

GRAY = np.arange(12, dtype=np.uint8).reshape(3, 4)
DEEP = np.arange(12, dtype=np.uint16).reshape(3, 4) * 1000
COLOUR = np.arange(36, dtype=np.uint8).reshape(3, 4, 3)


@pytest.mark.parametrize("padding", [0, 5])
@pytest.mark.parametrize("big", [False, True])
def test_encodings_are_read(padding: int, big: bool) -> None:
    def read(array: np.ndarray, encoding: str) -> np.ndarray:
        return images.array(ros.image(array, encoding, padding, big))

    assert np.array_equal(read(GRAY, "mono8"), GRAY)
    deep = read(DEEP, "mono16")
    assert np.array_equal(deep, DEEP)
    assert deep.dtype == np.uint16
    assert deep.dtype.isnative
    assert np.array_equal(read(COLOUR, "rgb8"), COLOUR)
    assert np.array_equal(read(COLOUR, "bgr8"), COLOUR[:, :, ::-1])
    alpha = np.dstack([COLOUR, np.full((3, 4), 255, np.uint8)])
    assert np.array_equal(read(alpha, "rgba8"), COLOUR)
    assert np.array_equal(read(alpha, "bgra8"), COLOUR[:, :, ::-1])
    assert np.array_equal(read(COLOUR.astype(np.uint16) * 99, "rgb16"), COLOUR.astype(np.uint16) * 99)


def test_data_may_be_any_bytes() -> None:
    message = ros.image(GRAY, "mono8")
    for data in (bytearray(message.data), list(message.data), memoryview(message.data)):
        message.data = data
        assert np.array_equal(images.array(message), GRAY)


def test_what_is_no_picture_is_refused() -> None:
    message = ros.image(GRAY, "mono8")
    message.encoding = "bayer_rggb8"
    with pytest.raises(ValueError, match="bayer_rggb8"):
        images.array(message)
    message = ros.image(COLOUR, "rgb8")
    message.data = message.data[:-1]
    with pytest.raises(ValueError, match="don't fit"):
        images.array(message)
    message.step = 3
    with pytest.raises(ValueError, match="don't fit"):
        images.array(message)


def test_distances_become_metres() -> None:
    depth = images.depth_image(np.array([[500, 1250, np.nan], [1, 2, 3]], np.float32))
    assert (depth.height, depth.width, depth.step, depth.encoding) == (2, 3, 12, "32FC1")
    metres = np.frombuffer(depth.data, np.float32)
    assert metres[0] == np.float32(0.5)
    assert metres[1] == np.float32(1.25)
    assert math.isnan(metres[2])
    message = ros.Image()
    for name, value in vars(depth).items():
        setattr(message, name, value)
