"""Frames of a robot's camera, and a slot for the newest."""

from __future__ import annotations

import itertools
import threading
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

from .camera import Camera
from .picture import Picture
from .pose import Odometry

T = TypeVar("T")
SUFFIXES = {".jpg", ".jpeg", ".png", ".pgm", ".ppm", ".pnm"}


@dataclass(frozen=True)
class Frame:
    """A picture, its name, and when it was taken (`sec.nanosec` since 1970, UTC)."""

    id: str
    picture: Picture
    stamp: str
    camera: Camera | str | None = None
    """What it was taken with, or the name that the service keeps it by."""
    odometry: Odometry | None = None
    """The way since the last frame of the track."""


def stamp(time_s: float) -> str:
    """A time as `sec.nanosec`."""
    seconds, rest = divmod(time_s, 1)
    return f"{int(seconds)}.{int(rest * 1e9):09d}"


def pictures(folder: Path) -> list[Path]:
    """Its pictures, by name."""
    return sorted(path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES)


def played(folder: Path, rate_hz: float) -> Iterator[Frame]:
    """The pictures of a folder by name, as a camera would give them; for a rate of 0 as fast as they are taken."""
    began = time.monotonic()
    found = pictures(folder)
    if not found:
        raise OSError(f"{folder} holds no picture")
    for number, path in enumerate(found):
        if rate_hz > 0:
            time.sleep(max(0.0, began + number / rate_hz - time.monotonic()))
        yield Frame(path.name, path.read_bytes(), stamp(path.stat().st_mtime))


def written_ns(path: Path) -> int | None:
    """When it was written, in ns since 1970; `None` if it is gone: whoever writes frames takes old ones away."""
    try:
        return path.stat().st_mtime_ns
    except FileNotFoundError:
        return None


def watched(folder: Path, stop: threading.Event, poll_s: float = 0.05) -> Iterator[Frame]:
    """The newest picture of a folder whenever there is another: for a camera's program that writes files there.

    It should write under another name and rename: a file that is half written is a damaged picture.
    """
    last: tuple[str, int] | None = None
    while not stop.wait(poll_s):
        there = [(time_ns, path) for path in pictures(folder) if (time_ns := written_ns(path)) is not None]
        if not there:
            continue
        time_ns, newest = max(there)
        if (newest.name, time_ns) == last:
            continue
        try:
            picture = newest.read_bytes()
        except FileNotFoundError:
            continue
        last = newest.name, time_ns
        yield Frame(newest.name, picture, stamp(time_ns / 1e9))


def captured(number: int, stop: threading.Event) -> Iterator[Frame]:
    """What a camera of this machine sees; needs OpenCV (`pip install 'landmarkd[camera]'`)."""
    import cv2

    capture = cv2.VideoCapture(number)
    if not capture.isOpened():
        raise OSError(f"camera {number} can't be opened")
    try:
        for count in itertools.count(1):
            if stop.is_set():
                return
            ok, picture = capture.read()
            if not ok:
                raise OSError(f"camera {number} gives no more frames")
            # OpenCV has blue first.
            yield Frame(str(count), picture[:, :, ::-1], stamp(time.time()))
    finally:
        capture.release()


class Newest(Generic[T]):
    """A slot for one item, which a newer one replaces: a robot that had to wait sends its newest frame.

    Args:
        source: items that a thread of its own puts there, until they end or `close` is called. `None`: callers do.

    """

    def __init__(self, source: Iterable[T] | None = None) -> None:
        self.dropped = 0
        """How many a newer one replaced before anybody took them."""
        self._held: T | None = None
        self._ended = False
        self._fault: Exception | None = None
        self._changed = threading.Condition()
        if source is not None:
            threading.Thread(target=self._read, args=(source,), name="frames", daemon=True).start()

    def _read(self, source: Iterable[T]) -> None:
        try:
            for each in source:
                if not self.put(each):
                    return
        except Exception as fault:
            # `take` raises it.
            self._fault = fault
        self.close()

    def put(self, newer: T) -> bool:
        """Put it there; False after `close`."""
        with self._changed:
            if self._ended:
                return False
            self.dropped += self._held is not None
            self._held = newer
            self._changed.notify()
            return True

    def take(self, timeout_s: float | None = None) -> T | None:
        """The newest, waited for; `None` at the end, or when none comes in time.

        Raises:
            Exception: what the source raised.

        """
        with self._changed:
            self._changed.wait_for(lambda: self._held is not None or self._ended, timeout_s)
            newest, self._held = self._held, None
            if newest is None and self._fault is not None:
                raise self._fault
            return newest

    @property
    def ended(self) -> bool:
        """Whether nothing is there and nothing will come."""
        with self._changed:
            return self._ended and self._held is None and self._fault is None

    def close(self) -> None:
        """Take no more."""
        with self._changed:
            self._ended = True
            self._changed.notify()
