"""Where a camera is in a map, and where a flat landmark is before a camera.

Frames are those of REP 103 and 105: a body looks along x, with y to its left and z up; an optical frame has z forward,
x to the right and y down. `T_a_b` takes what is given in b to a. Metres and degrees; variances of angles in rad².
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Protocol


@dataclass(frozen=True)
class MapPose:
    """Where an exemplar's camera was, its body looking along x; of a flat landmark that of its plane, x its normal."""

    map: str
    """Name of the map."""
    x_m: float
    y_m: float
    yaw_deg: float
    """Turn about z, from x towards y."""
    z_m: float | None = None
    pitch_deg: float | None = None
    roll_deg: float | None = None
    sigma_m: float | None = None
    """Standard deviation of the position."""

    @classmethod
    def of(cls, body: Mapping[str, Any]) -> MapPose:
        """From the service's answer."""
        return cls(**{name: body[name] for name in cls.__dataclass_fields__ if body.get(name) is not None})

    def body(self) -> dict[str, Any]:
        """As the service takes it."""
        return {name: value for name, value in asdict(self).items() if value is not None}


@dataclass(frozen=True)
class Odometry:
    """How the camera's body has moved since the frame before, in its frame then: forward, to the left, turned left."""

    dx_m: float
    dy_m: float
    dyaw_deg: float


@dataclass(frozen=True)
class PlacePose:
    """Where the camera's body is in the map, by the exemplars that agree or by all frames of a track."""

    map: str
    x_m: float
    y_m: float
    yaw_deg: float
    covariance: tuple[float, ...]
    """Of x, y and yaw: 3×3, row by row, in metres and radians."""
    method: str
    """How it was found."""
    support: tuple[str, ...] = ()
    """Ids of the exemplars that it rests on."""
    lost: bool = False
    """Of a track: its frames contradict the pose, or don't tell one."""

    @classmethod
    def of(cls, body: Mapping[str, Any]) -> PlacePose:
        """From the service's answer."""
        return cls(
            map=body["map"],
            x_m=float(body["x_m"]),
            y_m=float(body["y_m"]),
            yaw_deg=float(body["yaw_deg"]),
            covariance=tuple(map(float, body["covariance"])),
            method=body.get("method", ""),
            support=tuple(body.get("support") or ()),
            lost=bool(body.get("lost")),
        )


@dataclass(frozen=True)
class LandmarkPose:
    """`T_camera_landmark`: where a flat landmark is before the camera, in the camera's optical frame."""

    translation_m: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]
    """x, y, z, w."""
    covariance: tuple[float, ...] | None = None
    """Of the translation (m) and of the rotation (rad): 6×6, row by row."""
    error_px: float | None = None
    """Root mean square distance of the points from where it lays them."""
    ambiguous: bool = False
    """Whether `alternative` explains the points almost as well: act on neither alone."""
    alternative: LandmarkPose | None = None
    """The other solution of a plane seen by one camera."""

    @classmethod
    def of(cls, placement: HasMembers) -> LandmarkPose | None:
        """From a placement; `None` for an exemplar without a size, or a frame without a camera."""
        members = placement.to_dict()
        solution, other = members.get("T_camera_landmark"), members.get("alternative")
        if solution is None:
            return None
        return cls(
            **solved(solution),
            ambiguous=bool(members.get("ambiguous")),
            alternative=None if other is None else cls(**solved(other)),
        )


class HasMembers(Protocol):
    """A generated type."""

    def to_dict(self) -> dict[str, Any]:
        """All that the answer has."""


def solved(body: Mapping[str, Any]) -> dict[str, Any]:
    """The fields of one solution."""
    x_m, y_m, z_m = map(float, body["translation_m"])
    x, y, z, w = map(float, body["quaternion"])
    covariance = body.get("covariance")
    return {
        "translation_m": (x_m, y_m, z_m),
        "quaternion": (x, y, z, w),
        "covariance": None if covariance is None else tuple(map(float, covariance)),
        "error_px": body.get("error_px"),
    }
