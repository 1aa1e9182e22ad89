#!/usr/bin/env python3
"""The node under ROS itself, against the real service: needs a sourced ROS 2 workspace, and LANDMARKD_BINARY.

A publisher of pictures stands in for the camera. Fails unless the node says where it is, and how it does.
"""

from __future__ import annotations

import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "python" / "tests"))

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from drawing import room
from fixtures import teach_rooms
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import Image
from service import Service
from std_srvs.srv import Trigger
from vision_msgs.msg import Classification, Detection2DArray

from landmarkd import Client
from landmarkd_ros.localisation import LATCHED
from landmarkd_ros.node import LandmarkdNode

PATIENCE_S = 30.0


def main() -> None:
    """Configure, activate, ask, teach, clean up."""
    service = Service(Path(tempfile.mkdtemp()))
    with Client(service.url) as client:
        teach_rooms(client, "home")
    rclpy.init()
    node, camera = LandmarkdNode(), Node("camera")
    node.set_parameters([Parameter("service", value=service.url), Parameter("label", value="stairs")])
    executor = MultiThreadedExecutor(num_threads=4)
    executor.add_node(node)
    executor.add_node(camera)
    threading.Thread(target=executor.spin, daemon=True).start()
    heard: dict[str, Any] = {}
    for kind, topic, qos in (
        (Classification, "place", LATCHED),
        (Detection2DArray, "detections", 10),
        (DiagnosticArray, "/diagnostics", 1),
    ):
        camera.create_subscription(kind, topic, lambda message, topic=topic: heard.update({topic: message}), qos)
    publisher = camera.create_publisher(Image, "image", qos_profile_sensor_data)
    teach = camera.create_client(Trigger, "/landmarkd/teach")
    try:
        node.trigger_configure()
        node.trigger_activate()
        picture = room(1)
        ends = time.monotonic() + PATIENCE_S
        while len(heard) < 3:
            assert time.monotonic() < ends, f"only heard of {sorted(heard)}"
            message = Image()
            message.header.frame_id, message.header.stamp = "camera", camera.get_clock().now().to_msg()
            message.height, message.width, message.encoding, message.step = *picture.shape, "mono8", picture.shape[1]
            message.data = picture.tobytes()
            publisher.publish(message)
            time.sleep(0.1)
        assert heard["place"].results[0].class_id == "stairs", heard["place"]
        assert heard["detections"].detections, heard["detections"]
        assert teach.wait_for_service(PATIENCE_S)
        taught = teach.call(Trigger.Request())
        assert taught.success, taught.message
        node.trigger_deactivate()
        node.trigger_cleanup()
    finally:
        node.destroy_node()
        camera.destroy_node()
        rclpy.try_shutdown()
        service.stop()
    print("under ROS: configured, asked, answered, taught, cleaned up")


if __name__ == "__main__":
    main()
