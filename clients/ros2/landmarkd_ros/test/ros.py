"""Stand-ins of ROS's messages and of what the node takes from rclpy: fields by name, and nothing else may be set."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from types import ModuleType, SimpleNamespace
from typing import Any, ClassVar


def message_type(name: str, **fields: Callable[[], Any]) -> type:
    """A message type with these fields, each with what makes its default."""

    def init(self: Any) -> None:
        for field, make in fields.items():
            setattr(self, field, make())

    return type(name, (), {"__slots__": tuple(fields), "__init__": init})


Time = message_type("Time", sec=int, nanosec=int)
Header = message_type("Header", stamp=Time, frame_id=str)
Image = message_type(
    "Image", header=Header, height=int, width=int, encoding=str, is_bigendian=int, step=int, data=bytes
)
CameraInfo = message_type("CameraInfo", header=Header, height=int, width=int, k=list)
PoseWithCovariance = message_type("PoseWithCovariance", pose=object, covariance=list)
ObjectHypothesis = message_type("ObjectHypothesis", class_id=str, score=float)
ObjectHypothesisWithPose = message_type(
    "ObjectHypothesisWithPose", hypothesis=ObjectHypothesis, pose=PoseWithCovariance
)
Point2D = message_type("Point2D", x=float, y=float)
Pose2D = message_type("Pose2D", position=Point2D, theta=float)
BoundingBox2D = message_type("BoundingBox2D", center=Pose2D, size_x=float, size_y=float)
Detection2D = message_type("Detection2D", header=Header, results=list, bbox=BoundingBox2D, id=str)
Detection2DArray = message_type("Detection2DArray", header=Header, detections=list)
Classification = message_type("Classification", header=Header, results=list)

VISION = {
    kind.__name__: kind
    for kind in (
        ObjectHypothesis,
        ObjectHypothesisWithPose,
        Point2D,
        Pose2D,
        BoundingBox2D,
        Detection2D,
        Detection2DArray,
        Classification,
    )
}


def image(array: Any, encoding: str, padding: int = 0, big: bool = False) -> Any:
    """A message of an array as it is."""
    made = Image()
    made.height, made.width = array.shape[:2]
    made.encoding, made.is_bigendian = encoding, int(big)
    rows = array.astype(array.dtype.newbyteorder(">" if big else "<")).reshape(made.height, -1)
    made.step = rows.shape[1] * rows.itemsize + padding
    made.data = b"".join(row.tobytes() + b"\xee" * padding for row in rows)
    return made


class Publisher:
    """Keeps what is published."""

    def __init__(self) -> None:
        self.published: list[Any] = []
        self.came = threading.Event()

    def publish(self, message: Any) -> None:
        self.published.append(message)
        self.came.set()


class Node:
    """What the node takes from `rclpy.node.Node`."""

    parameters: ClassVar[dict[str, Any]] = {}

    def __init__(self, name: str) -> None:
        self.name = name
        self.publishers: dict[str, Publisher] = {}
        self.subscriptions: dict[str, Callable[[Any], object]] = {}
        self.log: list[str] = []

    def declare_parameter(self, name: str, default: Any) -> Any:
        return SimpleNamespace(value=self.parameters.get(name, default))

    def create_publisher(self, kind: type, topic: str, qos: object) -> Publisher:
        return self.publishers.setdefault(topic, Publisher())

    def create_subscription(self, kind: type, topic: str, callback: Callable[[Any], object], qos: object) -> None:
        self.subscriptions[topic] = callback

    def get_logger(self) -> Any:
        def note(text: str, **_: object) -> None:
            self.log.append(text)

        return SimpleNamespace(error=note, warning=note, fatal=note, info=note)

    def destroy_node(self) -> None:
        pass


class Synchronizer:
    """Calls back with what the test gives it, as if it had come at one time."""

    def __init__(self, subscribers: list[Any], queue_size: int, slop: float) -> None:
        self.topics = [subscriber.topic for subscriber in subscribers]

    def registerCallback(self, callback: Callable[..., object]) -> None:  # noqa: N802
        self.give = callback


def install() -> None:
    """Let `import rclpy` and the others find these."""

    def subscriber(node: Node, kind: type, topic: str, qos_profile: object) -> Any:
        return SimpleNamespace(topic=topic)

    for name, held in {
        "rclpy": {"init": None, "spin": None, "try_shutdown": None},
        "rclpy.executors": {"ExternalShutdownException": type("ExternalShutdownException", (Exception,), {})},
        "rclpy.node": {"Node": Node},
        "rclpy.qos": {"qos_profile_sensor_data": 10},
        "message_filters": {"Subscriber": subscriber, "ApproximateTimeSynchronizer": Synchronizer},
        "sensor_msgs": {},
        "sensor_msgs.msg": {"Image": Image, "CameraInfo": CameraInfo},
        "vision_msgs": {},
        "vision_msgs.msg": VISION,
    }.items():
        module = ModuleType(name)
        vars(module).update(held)
        sys.modules[name] = module
        parent, _, child = name.rpartition(".")
        if parent:
            setattr(sys.modules[parent], child, module)
