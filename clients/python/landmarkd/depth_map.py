"""Distances measured from a focal pair, as arrays."""

from __future__ import annotations

import enum
import io
from dataclasses import dataclass

import httpx
import numpy as np
import numpy.typing as npt

PLANES = ("depth", "sigma", "flags")


class DepthFlag(enum.IntFlag):
    """Why a pixel has no depth."""

    LOW_TEXTURE = 1
    SATURATED = 2
    OUT_OF_RANGE = 4
    INCONSISTENT = 8
    BORDER = 16
    AMBIGUOUS = 32


@dataclass(frozen=True, eq=False)
class DepthMap:
    """How far away everything is. Arrays are H×W, rows from the top, in the geometry of the near-focused picture."""

    depth_mm: npt.NDArray[np.float32]
    """Distance; NaN where there is none to be trusted."""
    sigma_mm: npt.NDArray[np.float32]
    """Its expected standard deviation; NaN where it is unknown."""
    flags: npt.NDArray[np.uint8]
    """Why a pixel has no depth, bits of `DepthFlag`; 0 where it has one."""
    near_focus_mm: float
    """The distance that the near-focused picture is focused at."""
    far_focus_mm: float
    """The distance that the far-focused picture is focused at."""
    coverage: float
    """Part of the pixels that have a depth."""
    warnings: list[str]
    """Warnings about the whole map."""

    @classmethod
    def of(cls, response: httpx.Response) -> DepthMap:
        """From an `application/x-npy` answer that holds all planes."""
        depth, sigma, flags = np.load(io.BytesIO(response.content), allow_pickle=False)
        headers = response.headers
        return cls(
            depth_mm=depth,
            sigma_mm=sigma,
            flags=flags.astype(np.uint8),
            near_focus_mm=float(headers["X-Near-Focus-Mm"]),
            far_focus_mm=float(headers["X-Far-Focus-Mm"]),
            coverage=float(headers["X-Coverage"]),
            warnings=[word for word in headers.get("X-Warnings", "").split(",") if word],
        )

    @property
    def summary(self) -> dict[str, float | int | None]:
        """Least, middle and largest distance in mm, coverage, and the number of pixels with each flag."""
        known = self.depth_mm[np.isfinite(self.depth_mm)]
        distances: dict[str, float | int | None] = {
            "min_mm": float(known.min()) if known.size else None,
            "median_mm": float(np.median(known)) if known.size else None,
            "max_mm": float(known.max()) if known.size else None,
            "coverage": self.coverage,
        }
        return distances | {str(flag.name).lower(): int(np.count_nonzero(self.flags & flag)) for flag in DepthFlag}
