"""When to retry: exponential backoff with full jitter."""

from __future__ import annotations

import random
import time
from collections.abc import Callable


class Backoff:
    """Waits whose bound doubles from failure to failure, each drawn uniformly from 0 to its bound ("full jitter").

    `Retry-After` is a lower bound, to which the draw is added, so that a thousand robots that were refused together
    don't retry together.

    Args:
        first_s: bound of the first wait, in seconds.
        most_s: largest bound of a wait, in seconds.
        now: the clock, in seconds.
        draw: a uniform draw from [0, 1).

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
        # Bounded, so that the power of two doesn't overflow.
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
