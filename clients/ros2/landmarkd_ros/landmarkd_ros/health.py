"""How the node is doing: counted as it goes, said on /diagnostics every second."""

from __future__ import annotations

import threading
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from landmarkd import Unreachable
from landmarkd.sighting import Sighting

PERIOD_S = 1.0
SILENCE_S = 5.0
"""A camera that gives no picture for so long is worth a warning."""


class Health:
    """Counts and the last problem. Several threads write."""

    def __init__(self, node: Any, service: str) -> None:
        self.node = node
        self.service = service
        self.frames_in = 0
        """Pictures that came while the node was active."""
        self.asked = 0
        self.answered = 0
        self.dropped = 0
        """Pictures that a newer one replaced, or that nobody answered."""
        self.lost = False
        """Whether the track says so."""
        self._reachable = False
        self._source = ""
        self._release = ""
        self._version = ""
        self._problem = ""
        self._latency_ms = 0.0
        self._last_in = time.monotonic()
        self._lock = threading.Lock()
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 1)
        self._timer = node.create_timer(PERIOD_S, self.publish)

    def came(self) -> None:
        """A picture came."""
        with self._lock:
            self.frames_in += 1
            self._last_in = time.monotonic()

    def drop(self, count: int = 1) -> None:
        """Pictures weren't answered."""
        with self._lock:
            self.dropped += count

    def ask(self) -> None:
        """A picture is asked about."""
        with self._lock:
            self.asked += 1

    def answer(self, sighting: Sighting) -> None:
        """A picture was answered, by the service or in its place."""
        with self._lock:
            self.answered += 1
            self._source = sighting.source
            self._version, self._latency_ms = str(sighting.version), sighting.asked_ms
            if sighting.source != "local":
                self._reachable, self._problem = True, ""

    def reached(self, release: str) -> None:
        """The service said what it is."""
        with self._lock:
            self._reachable, self._release = True, release

    def problem(self, fault: Exception | None) -> None:
        """A picture wasn't answered, for this reason."""
        with self._lock:
            self._source = ""
            self._problem, self._reachable = str(fault or ""), not isinstance(fault, Unreachable)

    def status(self) -> DiagnosticStatus:
        """The node's status now."""
        silent_s = time.monotonic() - self._last_in
        with self._lock:
            level, message = DiagnosticStatus.OK, "answers"
            if not self.node.active:
                message = "inactive"
            elif self._source == "local":
                level, message = DiagnosticStatus.WARN, "the service is away: the local one answers in its place"
            elif not self._reachable:
                level, message = DiagnosticStatus.ERROR, self._problem or "the service wasn't reached yet"
            elif self._problem:
                level, message = DiagnosticStatus.WARN, self._problem
            elif silent_s > SILENCE_S:
                level, message = DiagnosticStatus.WARN, f"no picture came for {silent_s:.0f} s"
            elif self.lost:
                level, message = DiagnosticStatus.WARN, "lost: the track knows no pose"
            values = {
                "service": self.service,
                "reachable": self._reachable,
                "release": self._release,
                "version": self._version,
                "source": self._source,
                "latency_ms": f"{self._latency_ms:.1f}",
                "frames_in": self.frames_in,
                "asked": self.asked,
                "answered": self.answered,
                "dropped": self.dropped,
                "last_problem": self._problem,
            }
        status = DiagnosticStatus()
        status.level, status.name, status.message = level, f"{self.node.get_name()}: recognition", message
        status.hardware_id = self.node.get_parameter("robot_id").value
        for key, value in values.items():
            pair = KeyValue()
            pair.key, pair.value = key, str(value)
            status.values.append(pair)
        return status

    def publish(self) -> None:
        """Publish it."""
        array = DiagnosticArray()
        array.header.stamp = self.node.get_clock().now().to_msg()
        array.status = [self.status()]
        self._publisher.publish(array)

    def close(self) -> None:
        """Say no more."""
        self.node.destroy_timer(self._timer)
        self.node.destroy_publisher(self._publisher)
