"""`sensor_msgs/Image` to arrays and back, without ROS: anything with the message's fields will do.

Rows come from the top and may be padded (`step` bytes each). Arrays are H×W or H×W×3 in the order red, green, blue.
"""

from __future__ import annotations

import array as buffer
import sys
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt


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


RGB, BGR = (0, 1, 2), (2, 1, 0)
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
}


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
    if layout.order is None:
        return pixels.reshape(image.height, image.width)
    return pixels.reshape(image.height, image.width, layout.channels)[:, :, list(layout.order)]


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
