"""A picture as the service takes it: a file's bytes, or an array of gray levels or colours.

Arrays are H×W (gray) or H×W×3 (red, green, blue), of `uint8` or `uint16`, rows from the top. They are sent without
loss: to another machine as PNG if Pillow is installed (`pip install 'landmarkd[pictures]'`), all others as portable
maps, which cost no time to make.
"""

from __future__ import annotations

import io
import os
from typing import IO, Any, Union

import numpy as np
import numpy.typing as npt

try:
    from PIL import Image
except ImportError:
    Image = None  # type: ignore[assignment]

Picture = Union[str, "os.PathLike[str]", bytes, bytearray, memoryview, IO[bytes], "npt.NDArray[Any]"]
"""A path, the bytes of a file, an open file, or an array."""

SIGNATURES = {
    b"\xff\xd8": "image/jpeg",
    b"\x89PNG": "image/png",
    b"P5": "image/x-portable-graymap",
    b"P6": "image/x-portable-pixmap",
}


def encoded(picture: Picture, small: bool) -> bytes:
    """The bytes of a file that the service reads; of an array a `small` one, which takes time, or a plain one."""
    if isinstance(picture, np.ndarray):
        packed = small and Image is not None and picture.dtype == np.uint8
        return png(picture) if packed else portable_map(picture)
    if isinstance(picture, (bytes, bytearray, memoryview)):
        return bytes(picture)
    if isinstance(picture, (str, os.PathLike)):
        with open(picture, "rb") as file:
            return file.read()
    return picture.read()


def media_type(picture: bytes) -> str:
    """What the bytes are, by their beginning; the service looks for itself."""
    return next((name for start, name in SIGNATURES.items() if picture.startswith(start)), "application/octet-stream")


def portable_map(array: npt.NDArray[Any]) -> bytes:
    """A binary PGM or PPM file; 16-bit levels have their high byte first."""
    checked(array)
    height, width = array.shape[:2]
    head = b"P%d %d %d %d\n" % (5 if array.ndim == 2 else 6, width, height, np.iinfo(array.dtype).max)
    levels = array.astype(">u2") if array.dtype == np.uint16 else array
    return head + np.ascontiguousarray(levels).tobytes()


def png(array: npt.NDArray[Any]) -> bytes:
    """A PNG file of 8 bits."""
    checked(array)
    held = io.BytesIO()
    # Level 1: a robot would rather send a tenth more than wait.
    Image.fromarray(np.ascontiguousarray(array)).save(held, "PNG", compress_level=1)
    return held.getvalue()


def checked(array: npt.NDArray[Any]) -> None:
    """A shape and type that pictures have.

    Raises:
        ValueError: for any other.

    """
    if array.dtype not in (np.uint8, np.uint16) or not (array.ndim == 2 or (array.ndim == 3 and array.shape[2] == 3)):
        raise ValueError(
            f"a picture is an array of uint8 or uint16, H×W or H×W×3, and this one is {array.dtype} of {array.shape}"
        )
