"""The bridge from the real service to a broker."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import Listener, waited
from drawing import room
from service import Service

from landmarkd import Client, MapPose


def test_a_robot_that_is_recognised_is_a_vehicle_in_its_place(broker: str, listener: Listener, tmp_path: Path) -> None:
    service = Service(tmp_path)
    with Client(service.url, robot_id="r5") as robot:
        robot.create("hall")
        for number, label in enumerate(("dock", "gate", "shelf")):
            robot.teach("hall", label, room(number), pose=MapPose("hall", 3.0 * number, 1, 90, sigma_m=0.1))
        robot.train("hall")
        command = [sys.executable, "-m", "landmarkd_vda5050", "--service", service.url, "--broker", broker]
        bridge = subprocess.Popen([*command, "--robot", "r5", "--database", "hall"])
        try:
            waited(lambda: listener.of("uagv/v2/landmarkd/r5/connection"), 20)

            def told() -> bool:
                # The stream of events may begin a little later.
                robot.recognise("hall", room(1))
                return bool(listener.of("uagv/v2/landmarkd/r5/state"))

            waited(told, 20)
        finally:
            bridge.send_signal(signal.SIGTERM)
            bridge.wait(20)
            service.stop()
    position = listener.of("uagv/v2/landmarkd/r5/state")[0]["agvPosition"]
    assert (position["mapId"], position["positionInitialized"]) == ("hall", True)
    assert (position["x"], position["y"]) == pytest.approx((3, 1), abs=0.5)
