"""A robot's way: frames whose evidence adds up to a belief."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from types import TracebackType

from ._generated.models import LabelBeliefBody, LandmarkTrackedFrameBody, ObjectTrackedFrameBody
from .absent import given
from .camera import Camera
from .picture import Picture
from .pose import Odometry
from .recognition import Decision, Recognition, decision, fields


@dataclass(frozen=True)
class LabelBelief:
    """The belief in a label."""

    label: str
    probability: float
    exemplar: str | None = None
    """Id of its likeliest exemplar; `None` if nobody knows."""

    @classmethod
    def of(cls, body: LabelBeliefBody) -> LabelBelief:
        """From the service's answer."""
        return cls(body.label, body.probability, body.exemplar)


@dataclass(frozen=True)
class TrackedFrame(Recognition):
    """What a frame shows, and where the robot is by all of the track's. `decision` is the track's."""

    track: str = ""
    """Id of the track."""
    belief: list[LabelBelief] = field(default_factory=list)
    """The likeliest labels, best first."""
    elsewhere: float = 0.0
    """Probability of being where no exemplar was taken."""
    frame_decision: Decision | None = None
    """What this frame alone decides."""
    number: int = 0
    """Its number in the track, from 1."""
    counted: bool = True
    """False when it was the last frame sent again: the belief is as it was."""

    @classmethod
    def of_track(cls, body: LandmarkTrackedFrameBody | ObjectTrackedFrameBody) -> TrackedFrame:
        """From the service's answer."""
        return cls(
            **fields(body),
            track=str(body.track),
            belief=[LabelBelief.of(each) for each in body.belief],
            elsewhere=body.elsewhere,
            frame_decision=decision(given(body.frame.decision)),
            number=body.frame.number,
            counted=body.frame.counted,
        )


class Track:
    """A track that was begun; as a context it is ended with the block. It is gone ten minutes after its last frame."""

    def __init__(
        self, id: str, motion: str, warnings: list[str], add: Callable[..., TrackedFrame], end: Callable[[], None]
    ) -> None:
        self.id = id
        self.motion = motion
        """How robots are taken to move: `path` or `still`."""
        self.warnings = warnings
        self._add = add
        self._end = end

    def frame(
        self,
        picture: Picture,
        *,
        top: int = 5,
        explain: bool = False,
        camera: Camera | str | None = None,
        odometry: Odometry | None = None,
        frame_id: str | None = None,
        stamp: str | None = None,
    ) -> TrackedFrame:
        """Add the next frame. The last one sent again, with its `frame_id`, isn't counted twice.

        With a `camera` (or the name of a kept one) and the `odometry` since the frame before it tells a better `pose`.
        """
        return self._add(
            picture, top=top, explain=explain, camera=camera, odometry=odometry, frame_id=frame_id, stamp=stamp
        )

    def end(self) -> None:
        """End it: the service forgets it."""
        self._end()

    def __enter__(self) -> Track:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.end()
