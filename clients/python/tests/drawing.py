"""Pictures drawn for the tests: the same number gives the same levels."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt


def room(number: int, side_px: int = 160) -> npt.NDArray[np.uint8]:
    """A gray picture of boxes of many levels, unlike that of any other number."""
    numbers = np.random.default_rng(number)
    picture = np.full((side_px, side_px), 90, np.uint8)
    for _ in range(60):
        x, y = numbers.integers(0, side_px, 2)
        width, height = numbers.integers(6, 34, 2)
        picture[y : y + height, x : x + width] = numbers.integers(0, 256)
    return picture


def moved(picture: npt.NDArray[np.uint8], x_px: int, y_px: int) -> npt.NDArray[np.uint8]:
    """The same seen from a little aside."""
    return np.roll(picture, (y_px, x_px), (0, 1))


def texture(number: int, side_px: int = 160) -> npt.NDArray[np.float64]:
    """Noise about a middle level."""
    return np.random.default_rng(number).normal(128, 40, (side_px, side_px))


def blurred(picture: npt.NDArray[np.float64], sigma_px: float) -> npt.NDArray[np.uint8]:
    """A picture out of focus."""
    frequency = np.fft.fftfreq(len(picture))
    transfer = np.exp(-2 * (np.pi * sigma_px * frequency) ** 2)
    smooth = np.fft.ifft2(np.fft.fft2(picture) * transfer[:, None] * transfer).real
    return np.clip(np.round(smooth), 0, 255).astype(np.uint8)


def part(number: int, turn_deg: float = 0.0, side_px: int = 64) -> npt.NDArray[np.uint8]:
    """A light part with a brighter end on a dark ground, turned in the picture's plane."""
    rows, columns = np.mgrid[:side_px, :side_px] - (side_px - 1) / 2
    angle = np.radians(turn_deg)
    along, across = columns * np.cos(angle) + rows * np.sin(angle), rows * np.cos(angle) - columns * np.sin(angle)
    length, width = (0.4, 0.12) if number == 0 else (0.3, 0.25)
    inside = (abs(along) < length * side_px) & (abs(across) < width * side_px)
    picture = np.where(inside, 130 + 100 * (along > 0), 8)
    return picture.astype(np.uint8)
