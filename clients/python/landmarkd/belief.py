"""Where a robot is by many single recognitions: a discrete Bayes filter over places and "elsewhere".

The hidden state is the place: one of the version's labels, or elsewhere. The observation is the decision on a frame: a
label, or none. The version's training has measured the observation model (`Rates`); between frames the robot stays
where it is with probability `STAY`, and is otherwise anywhere. A track of the service knows more: single exemplars,
their order, and the weights of all votes. This filter is for single recognitions.
"""

from __future__ import annotations

from dataclasses import dataclass

from ._generated.models import LandmarkReportBody, VersionBody
from .absent import given
from .recognition import Decision
from .track import LabelBelief

STAY = 0.9
"""Probability that the robot is still at the place of the frame before."""
SURE = 0.98
"""Bound of all rates: they were measured on a few hundred other frames, so none is taken as 0 or 1."""
ELSEWHERE = 0.5
"""Probability of being elsewhere before the first frame."""


@dataclass(frozen=True)
class Rates:
    """The observation model of a version, as its training measured it."""

    named: float = 0.8
    """Part of the frames of known places that are decided rightly."""
    misnamed: float = 0.02
    """Part of the frames of known places that are decided wrongly."""
    refused: float = 0.9
    """Part of the frames of unknown places for which nothing is decided."""

    @classmethod
    def of(cls, version: VersionBody) -> Rates:
        """From a version's report; the defaults if it wasn't measured."""
        report = version.report
        reliability = given(report.reliability) if isinstance(report, LandmarkReportBody) else None
        if reliability is None:
            return cls()
        return cls(reliability.known_named, reliability.known_misnamed, reliability.unknown_refused)


class Belief:
    """The belief in each label and in being elsewhere; they sum to 1.

    Args:
        labels: how many labels the version knows; their names are learnt when they are observed.
        rates: the observation model.

    """

    def __init__(self, labels: int, rates: Rates | None = None) -> None:
        rates = rates or Rates()
        self.labels = max(labels, 1)
        self.elsewhere = ELSEWHERE
        self._observed: dict[str, float] = {}
        self._named = within(rates.named)
        self._misnamed = within(rates.misnamed)
        self._refused = within(rates.refused)

    def update(self, decision: Decision | None) -> None:
        """Move, then weigh by the decision on the next frame."""
        self._move()
        label = decision.label if decision else None
        if label is not None and label not in self._observed:
            self._observed[label] = self._unobserved / max(self.labels - len(self._observed), 1)
            self.labels = max(self.labels, len(self._observed))
        if label is None:
            known, elsewhere = within(1 - self._named - self._misnamed), self._refused
        else:
            # A wrong label is any of the others with equal probability; elsewhere, any of all.
            known, elsewhere = self._misnamed / max(self.labels - 1, 1), (1 - self._refused) / self.labels
        unobserved = self._unobserved * known
        for each in self._observed:
            self._observed[each] *= self._named if each == label else known
        self.elsewhere *= elsewhere
        total = sum(self._observed.values()) + unobserved + self.elsewhere
        self.elsewhere /= total
        self._observed = {each: probability / total for each, probability in self._observed.items()}

    def _move(self) -> None:
        """The motion model: stay, or be anywhere."""
        anywhere = (1 - STAY) / (self.labels + 1)
        self.elsewhere = STAY * self.elsewhere + anywhere
        self._observed = {each: STAY * probability + anywhere for each, probability in self._observed.items()}

    @property
    def _unobserved(self) -> float:
        """The belief in all labels together that weren't observed yet."""
        if len(self._observed) >= self.labels:
            return 0.0
        return max(0.0, 1.0 - self.elsewhere - sum(self._observed.values()))

    def best(self, top: int = 5) -> list[LabelBelief]:
        """The likeliest observed labels, best first."""
        ordered = sorted(self._observed.items(), key=lambda each: -each[1])
        return [LabelBelief(label, probability) for label, probability in ordered[:top]]

    @property
    def decision(self) -> Decision | None:
        """The label with a probability above 0.5."""
        best = self.best(1)
        if best and best[0].probability > 0.5:
            return Decision(best[0].label, best[0].probability)
        return None


def within(rate: float) -> float:
    """The rate, at least 1 - SURE and at most SURE."""
    return min(max(rate, 1 - SURE), SURE)
