"""The lens before the two sensors of a focal pair."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ._generated.models import OpticsBody


@dataclass(frozen=True)
class Optics:
    """One lens. Give `aperture_mm` or `f_number`, and `near_plane_mm` or `near_focus_mm`."""

    focal_length_mm: float
    plane_separation_mm: float
    """How much nearer to the lens the sensor of the far-focused picture stands."""
    pixel_pitch_um: float
    """Side of a pixel."""
    telecentric: bool = False
    """Whether a stop in the front focal plane keeps both pictures at one scale."""
    aperture_mm: float | None = None
    """Diameter of the aperture."""
    f_number: float | None = None
    """Focal length over diameter."""
    near_plane_mm: float | None = None
    """From the lens to the sensor of the near-focused picture."""
    near_focus_mm: float | None = None
    """Distance in the scene that the near-focused picture is focused at."""
    principal_point_px: tuple[float, float] | None = None
    """Where the optical axis meets the picture, x and y; its middle by default."""

    def body(self) -> OpticsBody:
        """As the service takes it."""
        members: dict[str, Any] = {name: value for name, value in vars(self).items() if value is not None}
        if self.principal_point_px is not None:
            members["principal_point_px"] = list(self.principal_point_px)
        return OpticsBody.from_dict(members)
