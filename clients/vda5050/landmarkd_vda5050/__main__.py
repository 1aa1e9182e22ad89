"""The bridge: decisions of a landmarkd service in, VDA 5050 out.

    python -m landmarkd_vda5050 --service http://fleet:8080 --broker mqtt://broker:1883 --robot r7 --robot r8=AMR-0008

Each robot (its `X-Robot-Id`) is a vehicle, by its serial number if one is given. The key of the service is
LANDMARKD_KEY, the broker's MQTT_USER and MQTT_PASSWORD of the environment.
"""

from __future__ import annotations

import argparse
import math
import os
import signal
import sys
import threading
from collections.abc import Mapping
from types import FrameType

from landmarkd import Client, Problem
from landmarkd.planar import Planar

from .state import Known
from .vehicle import Broker, Vehicle

TICK_S = 0.5


def follow(client: Client, database: str | None, vehicles: Mapping[str, Vehicle]) -> None:
    """Take in every decision about these robots, until the service refuses to tell."""
    for event in client.events(database=database, kinds=("decision",)):
        vehicle = vehicles.get(str(event.data["header"].get("robot_id")))
        if vehicle is not None:
            vehicle.learn(Known.of(event.data))


def arguments() -> argparse.ArgumentParser:
    """What the command line takes."""
    parser = argparse.ArgumentParser(prog="python -m landmarkd_vda5050", description="Robots as vehicles of VDA 5050.")
    parser.add_argument("--service", required=True, metavar="URL", help="the service; its key is LANDMARKD_KEY")
    parser.add_argument("--database", help="decisions of this one alone")
    parser.add_argument("--broker", required=True, metavar="URL", help="mqtt://host:1883 or mqtts://host:8883")
    parser.add_argument(
        "--robot", required=True, action="append", metavar="ID[=SERIAL]", help="a robot, and its serial number"
    )
    parser.add_argument("--interface", default="uagv", help="first part of the topics (%(default)s)")
    parser.add_argument("--manufacturer", default="landmarkd", help="third part of the topics (%(default)s)")
    parser.add_argument(
        "--mount", default="0,0,0", metavar="X_M,Y_M,YAW_DEG", help="where the camera sits on the vehicle (%(default)s)"
    )
    parser.add_argument(
        "--visualization", action="store_true", help="the position alone, beside the state of the vehicle's controller"
    )
    parser.add_argument("--stale-s", type=float, default=10.0, help="a position older than this is none (%(default)s)")
    return parser


def mounted(words: str) -> Planar:
    """`T_base_camera` by the command line."""
    x_m, y_m, yaw_deg = map(float, words.split(","))
    return Planar(x_m, y_m, math.radians(yaw_deg))


def main(words: list[str] | None = None) -> int:
    """Run the bridge until it is ended; the exit code."""
    parser = arguments()
    args = parser.parse_args(words)
    broker = Broker(
        args.broker,
        os.environ.get("MQTT_USER", ""),
        os.environ.get("MQTT_PASSWORD", ""),
        args.interface,
        args.manufacturer,
    )
    vehicles: dict[str, Vehicle] = {}
    stop = threading.Event()

    def end(number: int, frame: FrameType | None) -> None:
        raise SystemExit(128 + number)

    def tick() -> None:
        while not stop.wait(TICK_S):
            for vehicle in vehicles.values():
                vehicle.tick()

    signal.signal(signal.SIGTERM, end)
    try:
        mount = mounted(args.mount)
        for robot in args.robot:
            name, _, serial_number = robot.partition("=")
            vehicles[name] = Vehicle(
                broker, serial_number or name, mount, whole=not args.visualization, stale_s=args.stale_s
            )
    except ValueError as fault:
        parser.error(str(fault))
    threading.Thread(target=tick, name="tick", daemon=True).start()
    try:
        with Client(args.service) as client:
            follow(client, args.database, vehicles)
    except Problem as problem:
        print(f"landmarkd_vda5050: {problem}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    finally:
        stop.set()
        for vehicle in vehicles.values():
            vehicle.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
