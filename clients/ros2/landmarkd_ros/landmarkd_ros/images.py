"""`sensor_msgs/Image` and `CompressedImage` as the service takes pictures, and distances as an `Image`, without ROS.

Anything with the messages' fields will do. Rows come from the top and may be padded (`step` bytes each). Arrays are
H×W or H×W×3 in the order red, green, blue. A compressed picture stays as it is: the service decodes it.
"""

from __future__ import annotations

import array as buffer
import io
import sys
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt
from PIL import Image as Pillow


class ImageLike(Protocol):
    """The fields of `sensor_msgs/Image` that are read."""

    height: int
    width: int
    encoding: str
    is_bigendian: int
    step: int
    data: Any


@dataclass(frozen=True)
class Layout:
    """How a pixel is stored."""

    dtype: str
    channels: int
    order: tuple[int, ...] | None = None
    """Which channels are red, green and blue; `None` for gray."""
    luma: int | None = None
    """Of 4:2:2: which byte of a pixel is its luma; the other is U in even columns and V in odd ones."""
    mosaic: str = ""
    """Of a Bayer mosaic: the colours of its first two rows' first two pixels."""


RGB, BGR = (0, 1, 2), (2, 1, 0)
MOSAICS = ("rggb", "bggr", "gbrg", "grbg")
LAYOUTS = {
    "mono8": Layout("u1", 1),
    "8UC1": Layout("u1", 1),
    "mono16": Layout("u2", 1),
    "16UC1": Layout("u2", 1),
    "rgb8": Layout("u1", 3, RGB),
    "bgr8": Layout("u1", 3, BGR),
    # By convention of OpenCV, which the name comes from.
    "8UC3": Layout("u1", 3, BGR),
    "rgba8": Layout("u1", 4, RGB),
    "bgra8": Layout("u1", 4, BGR),
    "rgb16": Layout("u2", 3, RGB),
    "bgr16": Layout("u2", 3, BGR),
    "yuv422": Layout("u1", 2, luma=1),
    "uyvy": Layout("u1", 2, luma=1),
    "yuv422_yuy2": Layout("u1", 2, luma=0),
    "yuyv": Layout("u1", 2, luma=0),
    **{f"bayer_{mosaic}8": Layout("u1", 1, mosaic=mosaic) for mosaic in MOSAICS},
    **{f"bayer_{mosaic}16": Layout("u2", 1, mosaic=mosaic) for mosaic in MOSAICS},
}
FROM_YUV = np.array([[1.164, 0.0, 1.596], [1.164, -0.392, -0.813], [1.164, 2.017, 0.0]], np.float32)
"""Red, green, blue by Y − 16, U − 128, V − 128: ITU-R BT.601 of studio levels, as OpenCV converts them."""


def picture(message: Any) -> bytes | npt.NDArray[Any]:
    """The picture of an `Image` as an array, or the file of a `CompressedImage`.

    Raises:
        ValueError: a message that isn't read here.

    """
    if hasattr(message, "encoding"):
        return array(message)
    if "compressedDepth" in message.format:
        raise ValueError(f"format {message.format!r} is no picture of light: take the topic of the camera's pictures")
    return bytes(message.data)


def size_px(message: Any) -> tuple[int, int]:
    """Width and height; of a compressed picture by the head of its file."""
    if hasattr(message, "encoding"):
        return message.width, message.height
    with Pillow.open(io.BytesIO(bytes(message.data))) as opened:
        return opened.size


def stamp(time: Any) -> str:
    """A `builtin_interfaces/Time` as `sec.nanosec`."""
    return f"{time.sec}.{time.nanosec:09d}"


def array(image: ImageLike) -> npt.NDArray[Any]:
    """The picture of a message, `uint8` or `uint16`.

    Raises:
        ValueError: an encoding that isn't read here, or fewer bytes than the message says.

    """
    layout = LAYOUTS.get(image.encoding)
    if layout is None:
        raise ValueError(f"encoding {image.encoding!r} isn't read; these are: {', '.join(LAYOUTS)}")
    dtype = np.dtype(layout.dtype).newbyteorder(">" if image.is_bigendian else "<")
    row_bytes = image.width * layout.channels * dtype.itemsize
    data = np.frombuffer(bytes(image.data), np.uint8)
    if image.step < row_bytes or data.size < image.step * image.height:
        pixels_are = f"{image.width}×{image.height} pixels of {image.encoding}"
        raise ValueError(f"{pixels_are} don't fit {data.size} bytes in rows of {image.step}")
    rows = data[: image.step * image.height].reshape(image.height, image.step)[:, :row_bytes]
    pixels = np.ascontiguousarray(rows).view(dtype).astype(dtype.newbyteorder("="))
    if layout.mosaic:
        return demosaiced(pixels.reshape(image.height, image.width), layout.mosaic)
    if layout.channels == 1:
        return pixels.reshape(image.height, image.width)
    pixels = pixels.reshape(image.height, image.width, layout.channels)
    if layout.luma is not None:
        return from_yuv(pixels[:, :, layout.luma], pixels[:, :, 1 - layout.luma])
    return pixels[:, :, list(layout.order or RGB)]


def from_yuv(luma: npt.NDArray[np.uint8], chroma: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Colours of luma H×W and of chroma H×W, in which two neighbours share U (the left one's) and V (the right one's).

    Raises:
        ValueError: a width that pairs don't make up.

    """
    height, width = luma.shape
    if width % 2:
        raise ValueError(f"{width} columns aren't pairs, which 4:2:2 is made of")
    pairs = np.repeat(chroma.reshape(height, width // 2, 2), 2, axis=1)
    yuv = np.dstack([luma, pairs]).astype(np.float32) - np.array([16, 128, 128], np.float32)
    colours: npt.NDArray[np.float32] = yuv @ FROM_YUV.T + np.float32(0.5)
    return np.clip(colours, 0, 255).astype(np.uint8)


def demosaiced(raw: npt.NDArray[Any], mosaic: str) -> npt.NDArray[Any]:
    """Colours of a Bayer mosaic, bilinear: what a pixel lacks is the mean of its neighbours that have it.

    `mosaic` names the colours of the first two rows' first two pixels. At the border the mosaic goes on mirrored, which
    keeps its colours in place.

    Raises:
        ValueError: a picture of one row or column.

    """
    height, width = raw.shape
    if min(height, width) < 2:
        raise ValueError(f"{width}×{height} pixels are no mosaic")
    padded = np.pad(raw, 1, "reflect").astype(np.float32)
    rows, columns = np.mgrid[-1 : height + 1, -1 : width + 1] % 2
    channels = []
    for colour in "rgb":
        there = np.zeros(padded.shape, np.float32)
        for place in (at for at, letter in enumerate(mosaic) if letter == colour):
            there[(rows == place // 2) & (columns == place % 2)] = 1
        total, weight = blurred(padded * there), blurred(there)
        has = there[1:-1, 1:-1] > 0
        channels.append(np.where(has, raw, np.floor(total / weight + np.float32(0.5))))
    return np.dstack(channels).astype(raw.dtype)


def blurred(padded: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Sums over 3×3 neighbours with the weights 1 2 1, without the border."""
    across = padded[:, :-2] + 2 * padded[:, 1:-1] + padded[:, 2:]
    down: npt.NDArray[np.float32] = across[:-2] + 2 * across[1:-1] + across[2:]
    return down


@dataclass(frozen=True)
class DepthImage:
    """The fields of a `sensor_msgs/Image` of distances but for its header.

    By REP 118: 32-bit floating-point metres, NaN where nothing is known. Distances are along the optical axis of the
    camera that took the near-focused picture: the header's frame is that camera's optical frame (REP 103).
    """

    height: int
    width: int
    step: int
    data: buffer.array[int]
    encoding: str = "32FC1"
    is_bigendian: int = field(default=int(sys.byteorder == "big"))


def depth_image(depth_mm: npt.NDArray[np.float32]) -> DepthImage:
    """Distances in millimetres (NaN: unknown) as the fields of a depth image, in metres."""
    metres = np.ascontiguousarray(depth_mm / np.float32(1000), np.float32)
    height, width = metres.shape
    return DepthImage(height, width, 4 * width, buffer.array("B", metres.tobytes()))
