"""The robot's own belief."""

from __future__ import annotations

import pytest

from landmarkd import Decision
from landmarkd.belief import Belief, Rates


def total(belief: Belief) -> float:
    """The sum of all probabilities, with that of labels which were not observed."""
    return belief.elsewhere + sum(each.probability for each in belief.best(1000)) + belief._unobserved


def test_the_first_frame_is_bayes_by_hand() -> None:
    belief = Belief(4, Rates(named=0.8, misnamed=0.06, refused=0.9))
    belief.update(Decision("a", 0.9))
    # Before: half elsewhere, an eighth each label; after the step: 0.9 of that and 0.02 each.
    elsewhere, label = 0.9 * 0.5 + 0.02, 0.9 * 0.125 + 0.02
    a, others, away = label * 0.8, 3 * label * 0.06 / 3, elsewhere * 0.1 / 4
    assert belief.best()[0].probability == pytest.approx(a / (a + others + away))
    assert belief.elsewhere == pytest.approx(away / (a + others + away))
    assert total(belief) == pytest.approx(1)


def test_one_wrong_frame_does_not_move_a_robot() -> None:
    belief = Belief(10)
    for label in ("a", "a", "a", "b", "a"):
        belief.update(Decision(label, 0.9))
        assert total(belief) == pytest.approx(1)
    assert belief.decision is not None
    assert belief.decision.label == "a"


def test_a_robot_that_goes_on_is_followed() -> None:
    belief = Belief(3)
    for label in ("a", "a", "b", "b", "b"):
        belief.update(Decision(label, 0.9))
    assert belief.decision is not None
    assert belief.decision.label == "b"


def test_nothing_recognised_for_long_is_elsewhere() -> None:
    belief = Belief(3)
    belief.update(Decision("a", 0.9))
    for _ in range(6):
        belief.update(None)
    assert belief.decision is None
    assert belief.elsewhere > 0.8
    assert total(belief) == pytest.approx(1)


@pytest.mark.parametrize("labels", [0, 1, 2])
def test_few_labels_and_sure_rates_are_no_trouble(labels: int) -> None:
    belief = Belief(labels, Rates(1, 0, 1))
    for label in ("a", None, "b", "c", None, "a"):
        belief.update(Decision(label, 1.0) if label else None)
        assert total(belief) == pytest.approx(1)
        assert all(0 <= each.probability <= 1 for each in belief.best())
