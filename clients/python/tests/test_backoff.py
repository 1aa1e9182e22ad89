"""A service that refuses is asked later and later, and never before it says."""

from __future__ import annotations

import pytest
from drawing import room
from stub import Answer, Stub, recognition, refusal, version

from landmarkd import Client, Problem
from landmarkd.backoff import Backoff
from landmarkd.frames import Frame
from landmarkd.robot import Robot


def test_waits_double_up_to_a_bound_and_are_drawn() -> None:
    time_s = [0.0]
    backoff = Backoff(1, 10, now=lambda: time_s[0], draw=lambda: 0.5)
    assert backoff.due
    assert [backoff.failed() for _ in range(6)] == [0.5, 1, 2, 4, 5, 5]
    assert not backoff.due
    time_s[0] = 5
    assert backoff.due
    backoff.succeeded()
    assert backoff.failed() == 0.5
    assert backoff.failed(retry_after_s=20) == 21
    draws = {Backoff(1, 10).failed() for _ in range(20)}
    assert len(draws) > 10
    assert all(0 <= wait_s < 1 for wait_s in draws)


@pytest.mark.parametrize("status", [429, 503])
def test_a_busy_service_is_asked_again_after_retry_after(status: int) -> None:
    refusals = [refusal(status, "overloaded", "1"), refusal(status, "overloaded")]

    def answer(method: str, path: str) -> Answer:
        if path.endswith("/versions/1"):
            return version()
        return refusals.pop(0) if refusals else recognition("stairs")

    stub = Stub(answer)
    try:
        robot = Robot(Client(stub.url), "home", tracked=False, backoff=Backoff(0.2, 1))
        sightings = list(robot.sightings([Frame("1", room(0), "1.0")], every_frame=True))
    finally:
        stub.stop()
    times = [time_s for time_s, method, _ in stub.asked if method == "POST"]
    assert len(times) == 3
    assert 1 <= times[1] - times[0] < 1.4
    assert times[2] - times[1] < 0.6
    assert [each.frame_id for each in sightings] == ["1"]
    assert sightings[0].source == "single"
    assert sightings[0].belief[0].label == "stairs"


def test_what_waiting_does_not_mend_ends_the_loop() -> None:
    stub = Stub(lambda method, path: refusal(401, "key_required"))
    try:
        robot = Robot(Client(stub.url), "home")
        with pytest.raises(Problem) as caught:
            list(robot.sightings([Frame("1", room(0), "1.0")], every_frame=True))
    finally:
        stub.stop()
    assert caught.value.code == "key_required"
    assert len(stub.asked) == 1
