"""Pictures and archives drawn for the contract: the same number gives the same bytes."""

import io
import random
import struct
import tarfile
import zlib

SIDE_PX = 56


def pixels(number: int, side_px: int = SIDE_PX) -> list[bytearray]:
    """Rows of a scene: boxes of many levels."""
    numbers = random.Random(number)
    rows = [bytearray([90]) * side_px for _ in range(side_px)]
    for _ in range(14):
        x, y = numbers.randrange(side_px), numbers.randrange(side_px)
        width, height, level = numbers.randrange(3, 14), numbers.randrange(3, 14), numbers.randrange(256)
        for row in rows[y : y + height]:
            row[x : x + width] = bytes([level]) * len(row[x : x + width])
    return rows


def scene(number: int, side_px: int = SIDE_PX) -> bytes:
    """A scene as a gray PNG file."""
    rows = pixels(number, side_px)

    def chunk(name: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))

    header = struct.pack(">IIBBBBB", side_px, side_px, 8, 0, 0, 0, 0)
    data = zlib.compress(b"".join(b"\0" + bytes(row) for row in rows))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def map_of(number: int, colour: bool) -> bytes:
    """A scene as a portable gray or colour map."""
    rows = pixels(number)
    body = b"".join(bytes(level for level in row for _ in range(3 if colour else 1)) for row in rows)
    return b"P%d %d %d 255\n" % (6 if colour else 5, SIDE_PX, SIDE_PX) + body


def archive(numbers: list[int]) -> bytes:
    """A tar archive of training images."""
    held = io.BytesIO()
    with tarfile.open(fileobj=held, mode="w") as tar:
        for number in numbers:
            entry = tarfile.TarInfo(f"place-{number}/{number}.png")
            entry.size = len(scene(number))
            tar.addfile(entry, io.BytesIO(scene(number)))
    return held.getvalue()
