"""Distances by focal pairs: two pictures in, a depth image out."""

from __future__ import annotations

import threading
from typing import Any

import message_filters
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import CameraInfo, Image

from landmarkd import Client, DepthMap, Problem, Unreachable
from landmarkd.backoff import Backoff
from landmarkd.frames import Newest

from . import images


class Distances:
    """Measures the newest pair, again and again."""

    def __init__(self, node: Any, client: Client, calibration: str) -> None:
        self.node = node
        self.client = client
        self.calibration = calibration
        self._info: Any = None
        self._pairs: Newest[Any] = Newest()
        self._depth = node.create_lifecycle_publisher(Image, "depth/image", qos_profile_sensor_data)
        self._depth_info = node.create_lifecycle_publisher(CameraInfo, "depth/camera_info", qos_profile_sensor_data)
        self._described = node.create_subscription(
            CameraInfo, "near/camera_info", self._keep_info, qos_profile_sensor_data
        )
        self._sides = [
            message_filters.Subscriber(node, Image, name, qos_profile=qos_profile_sensor_data)
            for name in ("near", "far")
        ]
        self.pair = message_filters.ApproximateTimeSynchronizer(
            self._sides, queue_size=5, slop=node.get_parameter("pair_slop_s").value
        )
        self.pair.registerCallback(self._came)
        self._thread = threading.Thread(target=self._run, name="measure", daemon=True)
        self._thread.start()

    def _keep_info(self, info: Any) -> None:
        """The near camera's description, for the next distances."""
        self._info = info

    def _came(self, near: Any, far: Any) -> None:
        """A pair."""
        if self.node.active:
            self._pairs.put((near, far))

    def _run(self) -> None:
        """Measure until the node is cleaned up."""
        backoff = Backoff()
        while not self._pairs.ended:
            pair = self._pairs.take(0.5)
            # One that comes too early after a failure is left out.
            if pair is None or not backoff.due:
                continue
            near, far = pair
            try:
                depth = self.client.depth(
                    images.array(near),
                    images.array(far),
                    calibration=self.calibration,
                    stamp=images.stamp(near.header.stamp),
                )
            except ValueError as fault:
                self.node.get_logger().error(str(fault), throttle_duration_sec=10)
            except (Problem, Unreachable) as fault:
                wait_s = backoff.failed(fault.retry_after if isinstance(fault, Problem) else None)
                self.node.get_logger().warning(f"no distances: {fault}; asked again in {wait_s:.1f} s")
            else:
                backoff.succeeded()
                self._publish(depth, near.header)

    def _publish(self, depth: DepthMap, header: Any) -> None:
        """Publish distances, and the description of the near camera."""
        image = Image()
        image.header = header
        for name, value in vars(images.depth_image(depth.depth_mm)).items():
            setattr(image, name, value)
        self._depth.publish(image)
        if self._info is not None:
            info = self._info
            # It belongs to this picture.
            info.header = header
            self._depth_info.publish(info)

    def close(self) -> None:
        """End the thread."""
        self._pairs.close()
        self._thread.join(self.client.timeout_s + 1)
        for subscription in (self._described, *(side.sub for side in self._sides)):
            self.node.destroy_subscription(subscription)
        for publisher in (self._depth, self._depth_info):
            self.node.destroy_lifecycle_publisher(publisher)
