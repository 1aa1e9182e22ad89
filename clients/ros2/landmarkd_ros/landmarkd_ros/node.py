"""The node: pictures in, places, things and distances out.

    in   image               sensor_msgs/Image            asked about; the newest wins
         near, far           sensor_msgs/Image            a focal pair, with the parameter `calibration`
         near/camera_info    sensor_msgs/CameraInfo       passed through beside the distances
    out  place               vision_msgs/Classification   where the robot is, by all frames so far
         decision            vision_msgs/Classification   what to act on; no results when nothing is sure enough
         detections          vision_msgs/Detection2DArray  what is in the frame, and where
         depth/image         sensor_msgs/Image            distances along the optical axis, 32FC1, metres, NaN unknown
         depth/camera_info   sensor_msgs/CameraInfo       the near camera's

Calls to the service are made by threads of their own: callbacks only put the newest there.
"""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

import message_filters
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import CameraInfo, Image
from vision_msgs import msg as vision

from landmarkd import Client, DepthMap, Problem, Unreachable
from landmarkd.backoff import Backoff
from landmarkd.frames import Frame, Newest
from landmarkd.kept_version import KeptVersion
from landmarkd.robot import Robot
from landmarkd.stand_in import StandIn

from . import images, messages

PARAMETERS = {
    "service": "http://127.0.0.1:8080",
    "database": "home",
    "tracked": True,
    "motion": "auto",
    "robot_id": "",
    "timeout_s": 5.0,
    "keep": "",
    "local_binary": "",
    "calibration": "",
    "pair_slop_s": 0.02,
}
"""Parameters with their defaults; the key of the service is LANDMARKD_KEY of the environment."""
TYPES = {name: getattr(vision, name) for name in messages.NAMES}


class LandmarkdNode(Node):  # type: ignore[misc]
    """Asks the service about what the camera sees."""

    def __init__(self) -> None:
        super().__init__("landmarkd")
        parameters = {name: self.declare_parameter(name, default).value for name, default in PARAMETERS.items()}
        robot_id = parameters["robot_id"] or None
        self.client = Client(parameters["service"], robot_id=robot_id, timeout_s=parameters["timeout_s"])
        keep = Path(parameters["keep"]) if parameters["keep"] else None
        binary = parameters["local_binary"]
        self.robot = Robot(
            self.client,
            parameters["database"],
            tracked=parameters["tracked"],
            motion=parameters["motion"],
            kept=KeptVersion(keep / "version") if keep else None,
            stand_in=StandIn(Path(binary), keep / "data") if keep and binary else None,
        )
        self.frames: Newest[Any] = Newest()
        self.pairs: Newest[Any] = Newest()
        self.calibration = parameters["calibration"]
        self.camera_info: Any = None

        self.place = self.create_publisher(vision.Classification, "place", 10)
        self.decision = self.create_publisher(vision.Classification, "decision", 10)
        self.detections = self.create_publisher(vision.Detection2DArray, "detections", 10)
        self.create_subscription(Image, "image", self.frames.put, qos_profile_sensor_data)
        self.threads = [threading.Thread(target=self.recognise, name="recognise", daemon=True)]
        if self.calibration:
            self.depth = self.create_publisher(Image, "depth/image", qos_profile_sensor_data)
            self.depth_info = self.create_publisher(CameraInfo, "depth/camera_info", qos_profile_sensor_data)
            self.create_subscription(CameraInfo, "near/camera_info", self.keep_info, qos_profile_sensor_data)
            self.pair = message_filters.ApproximateTimeSynchronizer(
                [
                    message_filters.Subscriber(self, Image, name, qos_profile=qos_profile_sensor_data)
                    for name in ("near", "far")
                ],
                queue_size=5,
                slop=parameters["pair_slop_s"],
            )
            self.pair.registerCallback(lambda near, far: self.pairs.put((near, far)))
            self.threads.append(threading.Thread(target=self.measure, name="measure", daemon=True))
        for thread in self.threads:
            thread.start()

    def keep_info(self, info: Any) -> None:
        """The near camera's description, for the next distances."""
        self.camera_info = info

    # Places and things

    def recognise(self) -> None:
        """Ask about frames until the node ends, or is refused for good."""
        self.robot.keep_fresh()
        while not self.frames.ended:
            image = self.frames.take(0.5)
            if image is None:
                continue
            try:
                sighting = self.robot.see(frame(image))
            except ValueError as fault:
                self.get_logger().error(str(fault), throttle_duration_sec=10)
            except Problem as problem:
                self.get_logger().fatal(f"no more frames are asked about: {problem}")
                return
            else:
                if sighting is not None:
                    self.publish(sighting, image)

    def publish(self, sighting: Any, image: Any) -> None:
        """Publish what is known after a frame."""
        header = image.header
        for publisher, answer in (
            (self.place, messages.belief(sighting, header)),
            (self.decision, messages.classification(sighting.decision, header)),
            (self.detections, messages.detections(sighting.answer, header, image.width, image.height)),
        ):
            publisher.publish(messages.message(answer, TYPES))

    # Distances

    def measure(self) -> None:
        """Measure distances of pairs until the node ends."""
        backoff = Backoff()
        while not self.pairs.ended:
            pair = self.pairs.take(0.5)
            # One that comes too early after a failure is left out.
            if pair is None or not backoff.due:
                continue
            near, far = pair
            try:
                depth = self.client.depth(
                    images.array(near), images.array(far), calibration=self.calibration, stamp=stamp(near.header.stamp)
                )
            except ValueError as fault:
                self.get_logger().error(str(fault), throttle_duration_sec=10)
            except (Problem, Unreachable) as fault:
                retry_after = fault.retry_after if isinstance(fault, Problem) else None
                wait_s = backoff.failed(retry_after)
                self.get_logger().warning(f"no distances: {fault}; asked again in {wait_s:.1f} s")
            else:
                backoff.succeeded()
                self.publish_depth(depth, near.header)

    def publish_depth(self, depth: DepthMap, header: Any) -> None:
        """Publish distances, and the description of the near camera."""
        image = Image()
        image.header = header
        for name, value in vars(images.depth_image(depth.depth_mm)).items():
            setattr(image, name, value)
        self.depth.publish(image)
        if self.camera_info is not None:
            info = self.camera_info
            # It belongs to this picture.
            info.header = header
            self.depth_info.publish(info)

    def destroy_node(self) -> None:
        """End the threads, and the local service if one runs."""
        self.frames.close()
        self.pairs.close()
        for thread in self.threads:
            thread.join(self.client.timeout_s + 1)
        self.robot.close()
        self.client.close()
        super().destroy_node()


def frame(image: Any) -> Frame:
    """An image as the robot's loop takes it."""
    taken = stamp(image.header.stamp)
    return Frame(f"{image.header.frame_id}:{taken}", images.array(image), taken)


def stamp(time: Any) -> str:
    """A `builtin_interfaces/Time` as `sec.nanosec`."""
    return f"{time.sec}.{time.nanosec:09d}"


def main(words: list[str] | None = None) -> None:
    """Run the node until it is shut down."""
    rclpy.init(args=words)
    node = LandmarkdNode()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
