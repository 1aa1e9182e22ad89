"""The lens that two pictures are taken with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from ._generated.models import OpticsBody


@dataclass(frozen=True)
class Optics:
    """One lens, and what the two pictures differ by.

    Focus: give `aperture_mm` or `f_number`, `near_plane_mm` or `near_focus_mm`, and `plane_separation_mm`.
    Aperture: give `apertures_mm` or `f_numbers`, `plane_mm` or `focus_mm`, and `range_end_mm`.
    A stack of three focus settings and more: give `aperture_mm` or `f_number`, and `planes_mm` or `focuses_mm`, the
    near-focused first.
    """

    focal_length_mm: float
    plane_separation_mm: float | None = None
    """How much nearer to the lens the sensor of the far-focused picture stands."""
    pixel_pitch_um: float | None = None
    """Side of a pixel."""
    telecentric: bool = False
    """Whether a stop in the front focal plane keeps both pictures at one scale."""
    aperture_mm: float | None = None
    """Diameter of the aperture."""
    f_number: float | None = None
    """Focal length over diameter."""
    aperture: Literal["unknown"] | None = None
    """In place of both: it is measured from the pictures, for depth maps alone."""
    near_plane_mm: float | None = None
    """From the lens to the sensor of the near-focused picture."""
    near_focus_mm: float | None = None
    """Distance in the scene that the near-focused picture is focused at."""
    principal_point_px: tuple[float, float] | None = None
    """Where the optical axis meets the picture, x and y; its middle by default."""
    apertures_mm: tuple[float, float] | None = None
    """Diameters of both apertures, in either order."""
    f_numbers: tuple[float, float] | None = None
    """Focal length over diameter of both apertures, in either order."""
    plane_mm: float | None = None
    """From the lens to the sensor of both pictures."""
    focus_mm: float | None = None
    """Distance in the scene that both pictures are focused at."""
    range_end_mm: float | None = None
    """How far the working range reaches, beyond the focus or before it.

    Blur is alike on both sides of the focus: what stands on the other side is measured as if it stood on this one.
    """
    planes_mm: tuple[float, ...] | None = None
    """From the lens to the sensor of each picture of a stack."""
    focuses_mm: tuple[float, ...] | None = None
    """Distances in the scene that the pictures of a stack are focused at."""

    def body(self) -> OpticsBody:
        """As the service takes it."""
        given = {name: value for name, value in vars(self).items() if value is not None}
        members: dict[str, Any] = {
            name: list(value) if isinstance(value, tuple) else value for name, value in given.items()
        }
        return OpticsBody.from_dict(members)
