"""Where a robot is by many single recognitions: a discrete Bayes filter over places and "elsewhere".

Hidden is the place: one of the version's labels, or elsewhere. Seen is what each frame decides: a label, or nothing.
How often which is seen at which place, the version's training has measured (`Rates`); between frames the robot stays
where it is with probability `STAY` and may otherwise be anywhere. A track of the service knows more: single exemplars,
their order, and how alike the votes are. This is for where there is no track.
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
"""No rate is taken to be nearer to 0 or 1 than this is: it was measured on a few hundred frames, and not these."""
ELSEWHERE = 0.5
"""Probability of being elsewhere before the first frame."""


@dataclass(frozen=True)
class Rates:
    """How a version decides, as its training measured it."""

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
        labels: how many labels the version knows; which they are shows as they are seen.
        rates: how the version decides.

    """

    def __init__(self, labels: int, rates: Rates | None = None) -> None:
        rates = rates or Rates()
        self.labels = max(labels, 1)
        self.elsewhere = ELSEWHERE
        self._seen: dict[str, float] = {}
        self._named = within(rates.named)
        self._misnamed = within(rates.misnamed)
        self._refused = within(rates.refused)

    def update(self, decision: Decision | None) -> None:
        """Take in what the next frame decides."""
        self._move()
        label = decision.label if decision else None
        if label is not None and label not in self._seen:
            self._seen[label] = self._unseen / max(self.labels - len(self._seen), 1)
            self.labels = max(self.labels, len(self._seen))
        if label is None:
            known, elsewhere = within(1 - self._named - self._misnamed), self._refused
        else:
            # A wrong label is any of the others; one that is seen elsewhere is any at all.
            known, elsewhere = self._misnamed / max(self.labels - 1, 1), (1 - self._refused) / self.labels
        unseen = self._unseen * known
        for each in self._seen:
            self._seen[each] *= self._named if each == label else known
        self.elsewhere *= elsewhere
        total = sum(self._seen.values()) + unseen + self.elsewhere
        self.elsewhere /= total
        self._seen = {each: probability / total for each, probability in self._seen.items()}

    def _move(self) -> None:
        """The robot goes on: what was believed is a little less sure."""
        anywhere = (1 - STAY) / (self.labels + 1)
        self.elsewhere = STAY * self.elsewhere + anywhere
        self._seen = {each: STAY * probability + anywhere for each, probability in self._seen.items()}

    @property
    def _unseen(self) -> float:
        """The belief in all labels together that no frame has decided for."""
        if len(self._seen) >= self.labels:
            return 0.0
        return max(0.0, 1.0 - self.elsewhere - sum(self._seen.values()))

    def best(self, top: int = 5) -> list[LabelBelief]:
        """The likeliest labels that were seen, best first."""
        ordered = sorted(self._seen.items(), key=lambda each: -each[1])
        return [LabelBelief(label, probability) for label, probability in ordered[:top]]

    @property
    def decision(self) -> Decision | None:
        """The label that is believed more than all else together."""
        best = self.best(1)
        if best and best[0].probability > 0.5:
            return Decision(best[0].label, best[0].probability)
        return None


def within(rate: float) -> float:
    """A rate that isn't surer than it can be."""
    return min(max(rate, 1 - SURE), SURE)
