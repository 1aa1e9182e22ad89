"""Decisions of the service as VDA 5050 messages, version 2.0: the mapping, without MQTT.

Metres and radians, x, y and theta of the vehicle in the map as VDA 5050 has it (right-handed, theta from x towards y).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime, timezone
from typing import Any

import numpy as np

from landmarkd import PlacePose
from landmarkd.planar import Planar, carried

VERSION = "2.0.0"
SIGMAS = math.sqrt(-2 * math.log(0.05))
"""Of a normal distribution in the plane 95 % lie within so many standard deviations along every axis: 2.45."""


@dataclass(frozen=True)
class Known:
    """What is known of a robot by its last decision."""

    label: str | None
    confidence: float
    """Probability that the label is right; 0 if there is none, 1 if a version without calibration decides."""
    pose: PlacePose | None
    lost: bool

    @classmethod
    def of(cls, decision: Mapping[str, Any]) -> Known:
        """From the data of an event of kind `decision`."""
        decided, pose = decision.get("decision") or {}, decision.get("pose")
        found = None if pose is None else PlacePose.of(pose)
        confidence = decided.get("confidence")
        return cls(
            label=decided.get("label"),
            confidence=0.0 if not decided else 1.0 if confidence is None else float(confidence),
            pose=found,
            lost=found is not None and found.lost,
        )


def position(known: Known, mounted: Planar, fresh: bool) -> dict[str, Any] | None:
    """`agvPosition`; `None` without a pose. `mounted` is `T_base_camera`, as the service tells the camera's pose."""
    if known.pose is None:
        return None
    seen = Planar(known.pose.x_m, known.pose.y_m, math.radians(known.pose.yaw_deg))
    base, covariance = carried(seen, np.array(known.pose.covariance).reshape(3, 3), mounted)
    sure = fresh and not known.lost
    return {
        "x": base.x_m,
        "y": base.y_m,
        "theta": math.remainder(base.yaw, math.tau),
        "mapId": known.pose.map,
        "positionInitialized": sure,
        "localizationScore": known.confidence if sure else 0.0,
        "deviationRange": SIGMAS * math.sqrt(max(0.0, float(np.linalg.eigvalsh(covariance[:2, :2])[-1]))),
    }


def state(known: Known, mounted: Planar, fresh: bool) -> dict[str, Any]:
    """`state` of a vehicle of which only the position is known, which is said in `information`."""
    information: list[dict[str, Any]] = [
        {
            "infoType": "positionOnly",
            "infoLevel": "INFO",
            "infoDescription": "battery, orders and safety aren't known to this source",
        }
    ]
    if known.label is not None:
        information.append(
            {
                "infoType": "place",
                "infoLevel": "INFO",
                "infoDescription": known.label,
                "infoReferences": [{"referenceKey": "label", "referenceValue": known.label}],
            }
        )
    found = position(known, mounted, fresh)
    return {
        "orderId": "",
        "orderUpdateId": 0,
        "lastNodeId": "",
        "lastNodeSequenceId": 0,
        "nodeStates": [],
        "edgeStates": [],
        "actionStates": [],
        "driving": False,
        # A vehicle that takes no orders from master control.
        "operatingMode": "MANUAL",
        "batteryState": {"batteryCharge": 0.0, "charging": False},
        "safetyState": {"eStop": "NONE", "fieldViolation": False},
        "errors": [] if fresh and not known.lost else [not_localised(fresh)],
        "information": information,
    } | ({} if found is None else {"agvPosition": found})


def not_localised(fresh: bool) -> dict[str, Any]:
    """The error of a vehicle that doesn't know where it is."""
    why = "its pictures contradict the position" if fresh else "no picture was answered of late"
    return {"errorType": "notLocalised", "errorLevel": "WARNING", "errorDescription": why}


def visualization(known: Known, mounted: Planar, fresh: bool) -> dict[str, Any]:
    """`visualization`: the position alone, beside the `state` that the vehicle's own controller sends."""
    found = position(known, mounted, fresh)
    return {} if found is None else {"agvPosition": found}


def connection(word: str) -> dict[str, Any]:
    """`connection`: ONLINE, OFFLINE or CONNECTIONBROKEN."""
    return {"connectionState": word}


def headed(
    header_id: int, manufacturer: str, serial_number: str, now: datetime, body: Mapping[str, Any]
) -> dict[str, Any]:
    """A message with the header that all have; `header_id` counts up for each topic."""
    return {
        "headerId": header_id,
        "timestamp": now.astimezone(timezone.utc).isoformat(timespec="milliseconds").replace("+00:00", "Z"),
        "version": VERSION,
        "manufacturer": manufacturer,
        "serialNumber": serial_number,
        **body,
    }
