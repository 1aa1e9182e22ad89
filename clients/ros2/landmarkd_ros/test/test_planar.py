"""Poses in the plane, against 4×4 matrices and draws."""

from __future__ import annotations

import math

import numpy as np
import pytest
import ros

from landmarkd.planar import Planar, carried
from landmarkd_ros import planar

A, B = Planar(1.0, 2.0, 0.7), Planar(-0.3, 0.5, -2.9)


def matrix(pose: Planar) -> np.ndarray:
    return ros.placed(pose.x_m, pose.y_m, pose.yaw)


def as_transform(pose: np.ndarray) -> ros.Message:
    return ros.transform("map", "camera", pose).transform


def test_poses_compose_as_matrices_do() -> None:
    assert matrix(A @ B) == pytest.approx(matrix(A) @ matrix(B))
    assert matrix(A.inverse) == pytest.approx(np.linalg.inv(matrix(A)))


def test_an_optical_frame_is_the_body_that_looks_along_x() -> None:
    looks = planar.camera(as_transform(matrix(A) @ ros.OPTICAL))
    assert looks is not None
    assert (looks.x_m, looks.y_m, looks.yaw) == pytest.approx((1.0, 2.0, 0.7))
    stands = planar.body(as_transform(matrix(B)))
    assert stands is not None
    assert stands.yaw == pytest.approx(-2.9)
    # Its x, which is what it looks along, points up.
    up = np.array([[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]], float)
    assert planar.body(as_transform(up)) is None
    assert planar.camera(as_transform(up.T @ ros.OPTICAL)) is None


def test_angles_turn_about_z_then_y_then_x() -> None:
    yaw, pitch, roll = 0.4, 0.2, -0.3
    about_y = np.eye(4)
    about_y[np.ix_((0, 2), (0, 2))] = [[math.cos(pitch), math.sin(pitch)], [-math.sin(pitch), math.cos(pitch)]]
    about_x = np.eye(4)
    about_x[1:3, 1:3] = [[math.cos(roll), -math.sin(roll)], [math.sin(roll), math.cos(roll)]]
    optical = ros.placed(0, 0, yaw) @ about_y @ about_x @ ros.OPTICAL
    assert planar.angles_deg(as_transform(optical)) == pytest.approx(tuple(map(math.degrees, (yaw, pitch, roll))))


def test_the_base_is_where_the_mounted_camera_says_with_the_spread_that_draws_have() -> None:
    mount = Planar(0.4, -0.1, 0.5)
    covariance = np.array([[4e-4, 1e-4, 2e-5], [1e-4, 9e-4, -3e-5], [2e-5, -3e-5, 1e-4]])
    base, of_base = carried(A @ mount, covariance, mount)
    assert (base.x_m, base.y_m, base.yaw) == pytest.approx((A.x_m, A.y_m, A.yaw))
    camera = A @ mount
    draws = np.random.default_rng(1).multivariate_normal([camera.x_m, camera.y_m, camera.yaw], covariance, 20_000)
    bases = [Planar(*draw) @ mount.inverse for draw in draws]
    spread = np.cov([[each.x_m, each.y_m, each.yaw] for each in bases], rowvar=False)
    # 20 000 draws tell a variance to 1 %; the rest is what is not linear in the turn.
    assert np.allclose(of_base, spread, rtol=0.1, atol=2e-5)
