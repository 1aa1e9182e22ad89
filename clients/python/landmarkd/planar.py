"""Poses in the plane that a robot drives on: `T_a_b` is the pose of b in a, and takes what is given in b to a."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True)
class Planar:
    """`T_a_b` in the plane."""

    x_m: float
    y_m: float
    yaw: float
    """In radians."""

    def __matmul__(self, other: Planar) -> Planar:
        """`T_a_b @ T_b_c` is `T_a_c`."""
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return Planar(
            self.x_m + cos * other.x_m - sin * other.y_m,
            self.y_m + sin * other.x_m + cos * other.y_m,
            math.remainder(self.yaw + other.yaw, math.tau),
        )

    @property
    def inverse(self) -> Planar:
        """`T_b_a`."""
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return Planar(-cos * self.x_m - sin * self.y_m, sin * self.x_m - cos * self.y_m, -self.yaw)


def carried(
    map_camera: Planar, covariance: npt.NDArray[np.float64], base_camera: Planar
) -> tuple[Planar, npt.NDArray[np.float64]]:
    """The base's pose and covariance (x, y, yaw; m, rad) by those of the camera that is fixed to it."""
    map_base = map_camera @ base_camera.inverse
    # The base lies (dx, dy) from the camera, and swings about it with yaw.
    dx, dy = map_base.x_m - map_camera.x_m, map_base.y_m - map_camera.y_m
    jacobian = np.array([[1, 0, -dy], [0, 1, dx], [0, 0, 1]])
    return map_base, jacobian @ covariance @ jacobian.T
