"""Transforms of tf as poses in the plane that a robot drives on.

A camera is an optical frame in tf (REP 103: z forward, x right, y down); in the plane it is its body, which looks
along x.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from landmarkd.planar import Planar

LEVEL = 0.1
"""Least length of a unit vector's part in the plane whose heading means anything: it is within 84° of level."""


def rotation(quaternion: Any) -> npt.NDArray[np.float64]:
    """The matrix of a `geometry_msgs/Quaternion`."""
    x, y, z, w = quaternion.x, quaternion.y, quaternion.z, quaternion.w
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def body(transform: Any) -> Planar | None:
    """A `geometry_msgs/Transform` of a body; `None` if it stands on end."""
    return headed(transform.translation, rotation(transform.rotation)[:, 0])


def camera(transform: Any) -> Planar | None:
    """A `geometry_msgs/Transform` of an optical frame, as its body; `None` if it looks straight up or down."""
    return headed(transform.translation, rotation(transform.rotation)[:, 2])


def headed(translation: Any, forward: npt.NDArray[np.float64]) -> Planar | None:
    """What is there and looks that way."""
    if math.hypot(forward[0], forward[1]) < LEVEL:
        return None
    return Planar(translation.x, translation.y, math.atan2(forward[1], forward[0]))


def angles_deg(transform: Any) -> tuple[float, float, float]:
    """Yaw, pitch and roll of the body of an optical frame: turned in this order about z, y and x; pitch looks down."""
    optical = rotation(transform.rotation)
    forward, left, up = optical[:, 2], -optical[:, 0], -optical[:, 1]
    yaw = math.atan2(forward[1], forward[0])
    pitch = math.asin(max(-1.0, min(1.0, -forward[2])))
    return math.degrees(yaw), math.degrees(pitch), math.degrees(math.atan2(left[2], up[2]))
