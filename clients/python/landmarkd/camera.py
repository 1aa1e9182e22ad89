"""A camera: the pinhole model with the distortion of Brown and Conrady, as OpenCV and ROS (`plumb_bob`) have it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class Camera:
    """Focal lengths and principal point in pixels of a picture of this size, x right, y down."""

    fx: float
    fy: float
    cx: float
    cy: float
    width_px: int
    height_px: int
    k1: float = 0.0
    """Radial distortion, of the second power of the radius."""
    k2: float = 0.0
    """Of the fourth power."""
    p1: float = 0.0
    """Tangential distortion, along y."""
    p2: float = 0.0
    """Tangential distortion, along x."""
    k3: float = 0.0
    """Radial distortion, of the sixth power."""

    @classmethod
    def of(cls, body: Mapping[str, Any]) -> Camera:
        """From the service's answer; what is more in it is left out."""
        return cls(**{name: body[name] for name in cls.__dataclass_fields__ if body.get(name) is not None})

    def body(self) -> dict[str, Any]:
        """As the service takes it."""
        return asdict(self)
