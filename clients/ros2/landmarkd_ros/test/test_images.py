"""Images of ROS as arrays, and distances as images of ROS."""

from __future__ import annotations

import array
import io
import math

import numpy as np
import pytest
import ros
from PIL import Image

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
    for data in (message.data, message.data.tobytes(), message.data.tolist()):
        message.data = data
        assert np.array_equal(images.array(message), GRAY)


@pytest.mark.parametrize("mosaic", images.MOSAICS)
@pytest.mark.parametrize(("bits", "dtype"), [(8, np.uint8), (16, np.uint16)])
def test_a_mosaic_becomes_colours(mosaic: str, bits: int, dtype: type) -> None:
    # A ramp is linear, so that bilinear interpolation tells it everywhere but at the border.
    rows, columns = np.mgrid[:8, :10]
    colours = np.dstack([10 + 4 * rows, 60 + 2 * columns, 120 + 2 * rows + 4 * columns]).astype(dtype)
    raw = np.zeros((8, 10), dtype)
    for place, letter in enumerate(mosaic):
        at = np.s_[place // 2 :: 2, place % 2 :: 2]
        raw[at] = colours[(*at, "rgb".index(letter))]
    read = images.array(ros.image(raw, f"bayer_{mosaic}{bits}"))
    assert read.dtype == dtype
    assert np.array_equal(read[1:-1, 1:-1], colours[1:-1, 1:-1])


@pytest.mark.parametrize(("encoding", "luma"), [("yuv422", 1), ("uyvy", 1), ("yuv422_yuy2", 0), ("yuyv", 0)])
def test_luma_and_chroma_become_colours(encoding: str, luma: int) -> None:
    # Red, green, blue and white of BT.601: Y, U, V, two pixels each.
    known = [
        ((81, 90, 240), (254, 0, 0)),
        ((145, 54, 34), (0, 255, 0)),
        ((41, 240, 110), (0, 0, 255)),
        ((235, 128, 128), (255, 255, 255)),
    ]
    pixels = np.zeros((1, 8, 2), np.uint8)
    for pair, ((y, u, v), _) in enumerate(known):
        pixels[0, 2 * pair : 2 * pair + 2, luma] = y
        pixels[0, 2 * pair : 2 * pair + 2, 1 - luma] = u, v
    read = images.array(ros.image(pixels, encoding))
    expected = np.repeat([colour for _, colour in known], 2, axis=0)
    assert np.abs(read[0].astype(int) - expected).max() <= 2


def test_a_compressed_picture_is_passed_through() -> None:
    message = ros.message_type("sensor_msgs/msg/CompressedImage")()
    held = io.BytesIO()
    Image.fromarray(COLOUR).save(held, "PNG")
    message.format, message.data = "bgr8; png compressed bgr8", array.array("B", held.getvalue())
    assert images.picture(message) == held.getvalue()
    assert images.size_px(message) == (4, 3)
    message.format = "16UC1; compressedDepth png"
    with pytest.raises(ValueError, match="compressedDepth"):
        images.picture(message)


def test_what_is_no_picture_is_refused() -> None:
    message = ros.image(GRAY, "mono8")
    message.encoding = "nv21"
    with pytest.raises(ValueError, match="nv21"):
        images.array(message)
    message = ros.image(COLOUR, "rgb8")
    message.data = message.data[:-1]
    with pytest.raises(ValueError, match="don't fit"):
        images.array(message)
    message.step = 3
    with pytest.raises(ValueError, match="don't fit"):
        images.array(message)
    with pytest.raises(ValueError, match="pairs"):
        images.array(ros.image(np.zeros((2, 3, 2), np.uint8), "yuyv"))


def test_distances_become_metres() -> None:
    depth = images.depth_image(np.array([[500, 1250, np.nan], [1, 2, 3]], np.float32))
    assert (depth.height, depth.width, depth.step, depth.encoding) == (2, 3, 12, "32FC1")
    metres = np.frombuffer(depth.data, np.float32)
    assert metres[0] == np.float32(0.5)
    assert metres[1] == np.float32(1.25)
    assert math.isnan(metres[2])
    message = ros.message_type("sensor_msgs/msg/Image")()
    for name, value in vars(depth).items():
        setattr(message, name, value)
