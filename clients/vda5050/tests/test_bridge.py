"""Events of a stub in, MQTT out, through a real broker."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from typing import Any

import pytest
from conftest import Listener, waited
from stub import Answer, Stub, refusal
from test_state import decision

from landmarkd.planar import Planar
from landmarkd_vda5050.state import Known
from landmarkd_vda5050.vehicle import Broker, Vehicle

BASE = "uagv/v2/landmarkd"


def stream(*decisions: dict[str, Any], first: int = 1) -> Answer:
    """A stream of events that ends."""
    lines = [": hello", ""]
    for number, data in enumerate(decisions, first):
        lines += [f"id: {number}", "event: decision", f"data: {json.dumps(data)}", ""]
    return 200, "\n".join(lines) + "\n", {}


def test_decisions_become_states_of_their_vehicles(broker: str, listener: Listener) -> None:
    answers = [
        stream(decision(), decision(robot_id="r8"), decision(robot_id="stranger")),
        refusal(503, "overloaded", "0"),
        stream(decision(decision=None, pose=None), first=4),
    ]
    online = f"{BASE}/r7/connection", f"{BASE}/AMR-8/connection"
    stub = Stub(lambda method, path: answers.pop(0) if answers and all(map(listener.of, online)) else stream())
    command = [sys.executable, "-m", "landmarkd_vda5050", "--service", stub.url, "--broker", broker]
    bridge = subprocess.Popen([*command, "--robot", "r7", "--robot", "r8=AMR-8", "--database", "hall"])
    try:
        waited(lambda: len(listener.of(f"{BASE}/r7/state")) == 2, 20)
        streams = [each for each in stub.requests if each.path == "/v1/events"]
        assert streams[0].query == {"database": "hall", "kind": "decision"}
        # It went on after the last one that it saw, not from the beginning.
        after = [each.headers["last-event-id"] for each in streams if "last-event-id" in each.headers]
        assert after[:2] == ["3", "3"]
    finally:
        bridge.send_signal(signal.SIGTERM)
        assert bridge.wait(20) == 128 + signal.SIGTERM
        stub.stop()
    there, gone = listener.of(f"{BASE}/r7/state")
    assert (there["headerId"], gone["headerId"]) == (0, 1)
    assert (there["serialNumber"], there["agvPosition"]["mapId"]) == ("r7", "hall")
    assert "agvPosition" not in gone
    assert len(listener.of(f"{BASE}/AMR-8/state")) == 1
    waited(lambda: len(listener.of(f"{BASE}/r7/connection")) == 2)
    assert [each["connectionState"] for each in listener.of(f"{BASE}/r7/connection")] == ["ONLINE", "OFFLINE"]
    assert not [topic for topic, _, _ in listener.heard if "stranger" in topic]


def test_a_bridge_that_dies_is_told_by_its_will(broker: str, listener: Listener) -> None:
    stub = Stub(lambda method, path: stream())
    command = [sys.executable, "-m", "landmarkd_vda5050", "--service", stub.url, "--broker", broker, "--robot", "r9"]
    bridge = subprocess.Popen(command)
    try:
        waited(lambda: listener.of(f"{BASE}/r9/connection"), 20)
        bridge.kill()
        waited(lambda: len(listener.of(f"{BASE}/r9/connection")) == 2, 20)
    finally:
        bridge.kill()
        bridge.wait()
        stub.stop()
    assert listener.of(f"{BASE}/r9/connection")[-1]["connectionState"] == "CONNECTIONBROKEN"
    # Who comes later hears it too.
    late = Listener(int(broker.rpartition(":")[2]))
    waited(lambda: (f"{BASE}/r9/connection", True) in [(topic, kept) for topic, _, kept in late.heard])
    late.client.disconnect()
    late.client.loop_stop()


def test_a_position_that_is_stale_is_told_once_and_the_state_every_half_minute(broker: str, listener: Listener) -> None:
    time_s = [0.0]
    vehicle = Vehicle(Broker(broker), "r1", Planar(0, 0, 0), now_s=lambda: time_s[0])
    try:
        waited(lambda: listener.of(f"{BASE}/r1/connection"))
        vehicle.tick()
        vehicle.learn(Known.of(decision()))
        for time_s[0] in (1.0, 9.0, 11.0, 12.0, 40.0, 42.0):
            vehicle.tick()
        waited(lambda: len(listener.of(f"{BASE}/r1/state")) == 3)
    finally:
        vehicle.close()
    states = [each["agvPosition"]["positionInitialized"] for each in listener.of(f"{BASE}/r1/state")]
    # Known, stale after 10 s, and the heartbeat 30 s after that at 42 s.
    assert states == [True, False, False]


def test_what_is_learnt_while_the_broker_is_away_is_told_once_it_is_there(broker: str, listener: Listener) -> None:
    vehicle = Vehicle(Broker(broker), "r4", Planar(0, 0, 0))
    try:
        # Hardly connected yet.
        vehicle.learn(Known.of(decision()))
        waited(lambda: listener.of(f"{BASE}/r4/state"))
    finally:
        vehicle.close()
    assert listener.of(f"{BASE}/r4/state")[0]["headerId"] == 0


def test_beside_a_controller_only_the_position_is_told(broker: str, listener: Listener) -> None:
    vehicle = Vehicle(Broker(broker, manufacturer="maker"), "r2", Planar(0, 0, 0), whole=False)
    try:
        vehicle.learn(Known.of(decision()))
        waited(lambda: listener.of("uagv/v2/maker/r2/visualization"))
    finally:
        vehicle.close()
    assert [topic for topic, _, _ in listener.heard if "/r2/" in topic] == ["uagv/v2/maker/r2/visualization"]


def test_what_waiting_does_not_mend_ends_the_bridge(broker: str) -> None:
    stub = Stub(lambda method, path: refusal(401, "key_required"))
    command = [sys.executable, "-m", "landmarkd_vda5050", "--service", stub.url, "--broker", broker, "--robot", "r3"]
    try:
        ran = subprocess.run(command, capture_output=True, text=True, timeout=30, check=False, env=dict(os.environ))
    finally:
        stub.stop()
    assert ran.returncode == 2
    assert "key_required" in ran.stderr


@pytest.mark.parametrize("words", [["--broker", "http://x"], ["--broker", "mqtt://x", "--mount", "1,2"]])
def test_words_that_can_not_be_are_refused(words: list[str]) -> None:
    command = [sys.executable, "-m", "landmarkd_vda5050", "--service", "http://x", "--robot", "r", *words]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=30, check=False)
    assert ran.returncode == 2
    assert "usage" in ran.stderr
