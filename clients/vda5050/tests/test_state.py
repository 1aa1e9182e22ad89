"""The mapping."""

from __future__ import annotations

import math
import re
from datetime import datetime, timezone
from typing import Any

import pytest

from landmarkd.planar import Planar
from landmarkd_vda5050 import state
from landmarkd_vda5050.state import Known

HERE = Planar(0, 0, 0)


def decision(robot_id: str = "r7", **more: Any) -> dict[str, Any]:
    pose = {
        "map": "hall", "x_m": 1.0, "y_m": 2.0, "yaw_deg": 270.0, "method": "filter", "support": [],
        "covariance": [0.04, 0, 0, 0, 0.01, 0, 0, 0, 0.0001],
    }  # fmt: skip
    return {
        "at": "2026-01-01T00:00:00Z", "database": "hall", "version": 3,
        "header": {"robot_id": robot_id, "frame_id": "1", "stamp": "1.0"},
        "decision": {"label": "dock", "confidence": 0.97}, "pose": pose,
    } | more  # fmt: skip


def test_a_pose_becomes_the_position() -> None:
    position = state.position(Known.of(decision()), HERE, True)
    assert position is not None
    assert (position["x"], position["y"], position["mapId"]) == (1.0, 2.0, "hall")
    assert position["theta"] == pytest.approx(-math.pi / 2)
    assert (position["positionInitialized"], position["localizationScore"]) == (True, 0.97)
    # 95 % along the axis that is known worst, of which the deviation is 0.2 m.
    assert position["deviationRange"] == pytest.approx(0.2 * 2.4477, abs=1e-4)


def test_the_vehicle_is_where_its_camera_says() -> None:
    # A camera half a metre ahead of the vehicle, which looks to the left.
    position = state.position(Known.of(decision()), Planar(0.5, 0, math.pi / 2), True)
    assert position is not None
    assert abs(position["theta"]) == pytest.approx(math.pi)
    assert (position["x"], position["y"]) == pytest.approx((1.5, 2.0))


@pytest.mark.parametrize(("pose", "fresh"), [({"lost": True}, True), ({}, False)])
def test_what_is_lost_or_stale_is_no_position(pose: dict[str, Any], fresh: bool) -> None:
    whole = decision()
    known = Known.of(whole | {"pose": whole["pose"] | pose})
    said = state.state(known, HERE, fresh)
    assert not said["agvPosition"]["positionInitialized"]
    assert said["agvPosition"]["localizationScore"] == 0
    assert [each["errorType"] for each in said["errors"]] == ["notLocalised"]


def test_a_place_without_a_pose_is_information() -> None:
    said = state.state(Known.of(decision(pose=None)), HERE, True)
    assert "agvPosition" not in said
    assert said["information"][1]["infoReferences"] == [{"referenceKey": "label", "referenceValue": "dock"}]
    assert state.state(Known.of(decision(pose=None, decision=None)), HERE, True)["information"][1:] == []
    assert state.visualization(Known.of(decision(pose=None)), HERE, True) == {}


def test_messages_have_all_that_the_specification_requires() -> None:
    now = datetime(2026, 1, 2, 3, 4, 5, 678000, timezone.utc)
    message = state.headed(7, "maker", "r7", now, state.state(Known.of(decision()), HERE, True))
    # VDA 5050 2.0, 6.10.6.
    assert {
        "headerId", "timestamp", "version", "manufacturer", "serialNumber", "orderId", "orderUpdateId", "lastNodeId",
        "lastNodeSequenceId", "nodeStates", "edgeStates", "driving", "actionStates", "batteryState", "operatingMode",
        "errors", "safetyState",
    } <= message.keys()  # fmt: skip
    assert message["timestamp"] == "2026-01-02T03:04:05.678Z"
    assert re.fullmatch(r"2\.\d+\.\d+", message["version"])
    assert {"x", "y", "theta", "mapId", "positionInitialized"} <= message["agvPosition"].keys()
