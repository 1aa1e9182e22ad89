"""What a robot knows after a frame."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, fields
from typing import Literal

from .pose import PlacePose
from .recognition import Decision, Recognition
from .track import LabelBelief

Source = Literal["track", "single", "local"]


@dataclass(frozen=True)
class Sighting:
    """Where a robot is, by all frames so far."""

    frame_id: str
    stamp: str
    source: Source
    """Whose belief it is: the track's; the robot's own by single answers of the service, or of the local one."""
    version: int
    """The version that answered, as the service that answered counts."""
    digest: str
    """Its digest, the same everywhere."""
    decision: Decision | None
    """The label that is believed more than all else together, with that probability."""
    belief: list[LabelBelief]
    """The likeliest labels, best first."""
    elsewhere: float
    """Probability of being at no known place."""
    frame_decision: Decision | None
    """What this frame alone decides."""
    warnings: list[str]
    """Reasons to doubt this frame's answer."""
    asked_ms: float
    """From the question to the answer, in milliseconds."""
    answer: Recognition
    """All of this frame's answer, with the evidence."""
    pose: PlacePose | None = None
    """Where the camera is in the map, by the same as `belief`; `None` if nobody knows."""
    dropped: int = 0
    """Frames so far that nobody was asked about: a newer one came first, or nobody answered."""

    def line(self) -> str:
        """For people: one line."""
        words = [f"{each.label} {each.probability:.2f}" for each in self.belief]
        words.append(f"elsewhere {self.elsewhere:.2f}")
        where = self.decision.label if self.decision else "?"
        if self.pose is not None and not self.pose.lost:
            where += f" at {self.pose.x_m:.2f} m, {self.pose.y_m:.2f} m, {self.pose.yaw_deg:.0f}°"
        by = f"{self.source}, version {self.version}, {self.asked_ms:.0f} ms"
        return f"{self.frame_id}: {where} ({', '.join(words)}) by {by}"

    def json(self) -> str:
        """For programs: one line, without the evidence."""
        members = {each.name: getattr(self, each.name) for each in fields(self) if each.name != "answer"}
        return json.dumps(members, default=asdict)
