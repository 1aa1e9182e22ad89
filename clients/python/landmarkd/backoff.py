"""When to ask again after a failure: later each time, at a time nobody else has chosen too."""

from __future__ import annotations

import random
import time
from collections.abc import Callable


class Backoff:
    """Waits that double from failure to failure, each drawn evenly from nothing to its bound ("full jitter").

    A service that says when to come back (`Retry-After`) is never asked before; the draw comes on top, so that a
    thousand robots that were refused together don't come back together.

    Args:
        first_s: bound of the first wait, in seconds.
        most_s: largest bound of a wait, in seconds.
        now: the clock, in seconds.
        draw: an even draw from [0, 1).

    """

    def __init__(
        self,
        first_s: float = 0.5,
        most_s: float = 30.0,
        now: Callable[[], float] = time.monotonic,
        draw: Callable[[], float] = random.random,
    ) -> None:
        self.first_s = first_s
        self.most_s = most_s
        self.failures = 0
        """Failures since the last success."""
        self._now = now
        self._draw = draw
        self._due = float("-inf")

    def failed(self, retry_after_s: float | None = None) -> float:
        """Note a failure; the seconds until the next attempt is due."""
        # No power of two is taken that wouldn't fit.
        bound_s = min(self.most_s, self.first_s * 2.0 ** min(self.failures, 30))
        self.failures += 1
        wait_s = (retry_after_s or 0.0) + self._draw() * bound_s
        self._due = self._now() + wait_s
        return wait_s

    def succeeded(self) -> None:
        """Note a success: the next failure is a first one."""
        self.failures = 0
        self._due = float("-inf")

    @property
    def due(self) -> bool:
        """Whether it is time to ask again."""
        return self._now() >= self._due
