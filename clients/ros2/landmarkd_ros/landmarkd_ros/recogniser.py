"""Places and things: pictures in, answers out.

The callback only puts the newest picture there; a thread asks the service about it. What goes wrong is said on
/diagnostics, and asked again later: a database without a version may be trained, a service may come back, a key may be
mended.
"""

from __future__ import annotations

import math
import threading
import time
from dataclasses import dataclass
from typing import Any

from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from vision_msgs.msg import Classification, Detection2DArray

from landmarkd import Camera, Client, Odometry, Problem, Unreachable
from landmarkd.backoff import Backoff
from landmarkd.frames import Frame, Newest
from landmarkd.planar import Planar
from landmarkd.robot import Robot
from landmarkd.sighting import Sighting

from . import cameras, images, messages, planar
from .health import Health
from .localisation import LATCHED, Localisation
from .transforms import Transforms

IDLE_S = 5.0
"""Without pictures the service is asked every so often whether it is there."""


@dataclass(frozen=True)
class Seen:
    """A message of the camera and when it came, by the monotonic clock."""

    message: Any
    came_s: float


class Recogniser:
    """Asks about the newest picture, again and again."""

    def __init__(
        self,
        node: Any,
        client: Client,
        robot: Robot,
        transforms: Transforms,
        localisation: Localisation,
        health: Health,
    ) -> None:
        self.node = node
        self.client = client
        self.robot = robot
        self.transforms = transforms
        self.localisation = localisation
        self.health = health
        self.latest: Seen | None = None
        """The last picture, asked about or not."""
        self._info: Any = None
        self._frames: Newest[Any] = Newest()
        self._before: Planar | None = None
        self._stop = threading.Event()
        self._backoff = Backoff(first_s=1.0)
        self._dropped = 0
        self._places = node.create_lifecycle_publisher(Classification, "place", LATCHED)
        self._decisions = node.create_lifecycle_publisher(Classification, "decision", LATCHED)
        self._detections = node.create_lifecycle_publisher(Detection2DArray, "detections", 10)
        compressed = node.get_parameter("image_transport").value == "compressed"
        kind, topic = (CompressedImage, "image/compressed") if compressed else (Image, "image")
        self._subscriptions = [
            node.create_subscription(kind, topic, self._came, qos_profile_sensor_data),
            node.create_subscription(CameraInfo, "camera_info", self._described, qos_profile_sensor_data),
        ]
        self._thread = threading.Thread(target=self._run, name="recognise", daemon=True)
        self._thread.start()

    def _came(self, message: Any) -> None:
        """A picture."""
        self.latest = Seen(message, time.monotonic())
        if self.node.active:
            self.health.came()
            self._frames.put(message)

    def _described(self, info: Any) -> None:
        """What the camera is."""
        self._info = info

    def camera(self) -> Camera | None:
        """The camera by its description; `None` if there is none that the service takes, which is logged."""
        if self._info is None:
            return None
        try:
            return cameras.camera(self._info, self.node.get_parameter("rectified").value)
        except ValueError as fault:
            self.node.get_logger().warning(f"pictures are sent without camera: {fault}", throttle_duration_sec=60)
            return None

    # The thread

    def _run(self) -> None:
        """Ask until the node is cleaned up."""
        self.robot.keep_fresh()
        self._probe()
        asked_s = time.monotonic()
        while not self._stop.is_set():
            rate_hz = self.node.get_parameter("max_rate_hz").value
            if rate_hz > 0 and self._stop.wait(max(0.0, asked_s + 1 / rate_hz - time.monotonic())):
                return
            message = self._frames.take(0.5)
            self.health.drop(self._frames.dropped - self._dropped)
            self._dropped = self._frames.dropped
            if message is None:
                if time.monotonic() - asked_s > IDLE_S:
                    asked_s = time.monotonic()
                    self._probe()
            elif not self.node.active or not self._backoff.due:
                self.health.drop()
            else:
                asked_s = time.monotonic()
                self._ask(message)

    def _probe(self) -> None:
        """Ask the service what it is."""
        try:
            self.health.reached(self.client.info().version)
        except (Problem, Unreachable) as fault:
            self.health.problem(fault)

    def _ask(self, message: Any) -> None:
        """Ask about one picture."""
        self.health.ask()
        try:
            frame, place = self._frame(message)
            sighting = self.robot.see(frame)
            if sighting is None:
                self.health.drop()
                self.health.problem(self.robot.missed)
                return
            self._backoff.succeeded()
            if sighting.source == "track":
                self._before = place
            self._publish(sighting, message)
        except ValueError as fault:
            # Of this picture, not of the next.
            self._failed(fault, 0.0)
        except Exception as fault:
            # Whatever it is, it must not end the thread without a word.
            self._failed(fault, self._backoff.failed(fault.retry_after if isinstance(fault, Problem) else None))

    def _failed(self, fault: Exception, wait_s: float) -> None:
        """Note a picture without an answer."""
        self.health.drop()
        self.health.problem(fault)
        self.node.get_logger().warning(f"{fault!r}; asked again in {wait_s:.1f} s", throttle_duration_sec=10)

    def _frame(self, message: Any) -> tuple[Frame, Planar | None]:
        """A picture as the robot's loop takes it, and where odometry says its camera is."""
        header = message.header
        taken = images.stamp(header.stamp)
        place = self._by_odometry(header)
        odometry = None
        if place is not None and self._before is not None:
            step = self._before.inverse @ place
            odometry = Odometry(step.x_m, step.y_m, math.degrees(step.yaw))
        picture = images.picture(message)
        return Frame(f"{header.frame_id}:{taken}", picture, taken, self.camera(), odometry), place

    def _by_odometry(self, header: Any) -> Planar | None:
        """The camera's pose in the odometry's frame: of the camera, so that its mount needn't be known."""
        odom_frame = self.node.get_parameter("odom_frame").value
        if not odom_frame or not self.robot.tracked:
            return None
        moved = self.transforms.at(odom_frame, header.frame_id, header.stamp)
        return None if moved is None else planar.camera(moved)

    def _publish(self, sighting: Sighting, message: Any) -> None:
        """Publish what is known after a frame."""
        header, answer = message.header, sighting.answer
        # Only the box of an object needs it, which is the whole frame.
        size = images.size_px(message) if answer.kind == "objects" else (0, 0)
        self._places.publish(messages.belief(sighting, header))
        self._decisions.publish(messages.classification(sighting.decision, header))
        self._detections.publish(messages.detections(answer, header, *size))
        self.health.lost = sighting.pose is not None and sighting.pose.lost
        self.localisation.publish(sighting.pose, header)
        self.health.answer(sighting)

    def begin(self) -> None:
        """The node was activated: what odometry said before is forgotten."""
        self._before = None

    def close(self) -> None:
        """End the thread, the track, and the local service if one runs."""
        self._stop.set()
        self._frames.close()
        self._thread.join(self.client.timeout_s + 1)
        self.robot.close()
        for subscription in self._subscriptions:
            self.node.destroy_subscription(subscription)
        for publisher in (self._places, self._decisions, self._detections):
            self.node.destroy_lifecycle_publisher(publisher)
