"""Stand-ins of what the node takes from ROS, with the real definitions of the messages.

The definitions are those of `rosbags` for Humble; those of `vision_msgs` 4, which it doesn't have, are below. A
message's fields take what rclpy's do and nothing else, and all that is published is serialised to CDR as it would be
on the wire.
"""

from __future__ import annotations

import array
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from types import ModuleType, SimpleNamespace
from typing import Any, ClassVar

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

VISION = {
    "ObjectHypothesis": "string class_id\nfloat64 score",
    "ObjectHypothesisWithPose": "vision_msgs/ObjectHypothesis hypothesis\ngeometry_msgs/PoseWithCovariance pose",
    "Classification": "std_msgs/Header header\nvision_msgs/ObjectHypothesis[] results",
    "Point2D": "float64 x\nfloat64 y",
    "Pose2D": "vision_msgs/Point2D position\nfloat64 theta",
    "BoundingBox2D": "vision_msgs/Pose2D center\nfloat64 size_x\nfloat64 size_y",
    "Detection2D": (
        "std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\n"
        "vision_msgs/BoundingBox2D bbox\nstring id"
    ),
    "Detection2DArray": "std_msgs/Header header\nvision_msgs/Detection2D[] detections",
}
STORE = get_typestore(Stores.ROS2_HUMBLE)
for _name, _text in VISION.items():
    STORE.register(get_types_from_msg(_text, f"vision_msgs/msg/{_name}"))

NUMBERS = {
    "bool": np.bool_, "float32": np.float32, "float64": np.float64,
    "int8": np.int8, "uint8": np.uint8, "int16": np.int16, "uint16": np.uint16,
    "int32": np.int32, "uint32": np.uint32, "int64": np.int64, "uint64": np.uint64,
}  # fmt: skip


class Message:
    """A message as rclpy has it: set to its defaults, and refusing what doesn't fit."""

    NAME: ClassVar[str]

    def __init__(self) -> None:
        for name, kind in fields(self.NAME).items():
            object.__setattr__(self, name, default(kind))
        if self.NAME == "geometry_msgs/msg/Quaternion":
            # Its definition says so; what rosbags keeps of definitions has no defaults.
            self.w = 1.0

    def __setattr__(self, name: str, value: Any) -> None:
        kind = fields(self.NAME).get(name)
        if kind is None:
            raise AttributeError(f"{self.NAME} has no field {name}")
        assert fits(kind, value), f"{self.NAME}.{name} is {kind}, not {value!r}"
        object.__setattr__(self, name, value)


def fields(name: str) -> dict[str, Any]:
    """The fields of a message type with their kinds."""
    return {each: kind for each, kind in STORE.fielddefs[name][1] if each != "structure_needs_at_least_one_member"}


def fits(kind: Any, value: Any) -> bool:
    """Whether rclpy would take a value for a field."""
    node, detail = kind
    if node is Nodetype.BASE:
        return fits_base(detail[0], value)
    if node is Nodetype.NAME:
        return isinstance(value, message_type(detail))
    inner, count = detail
    if node is Nodetype.ARRAY and len(value) != count:
        return False
    if isinstance(value, np.ndarray):
        # rclpy takes arrays of numbers for fields of fixed length alone.
        return node is Nodetype.ARRAY and value.dtype == NUMBERS[inner[1][0]]
    if isinstance(value, (array.array, bytes)):
        return inner == (Nodetype.BASE, ("uint8", 0)) and (isinstance(value, bytes) or value.typecode == "B")
    return isinstance(value, (list, tuple)) and all(fits(inner, each) for each in value)


def fits_base(name: str, value: Any) -> bool:
    """The same for a number or a string."""
    if name == "string":
        return isinstance(value, str)
    if name == "byte":
        return isinstance(value, bytes) and len(value) == 1
    if name == "bool":
        return isinstance(value, bool)
    if name.startswith("float"):
        return isinstance(value, float)
    limits = np.iinfo(NUMBERS[name])
    return isinstance(value, int) and limits.min <= value <= limits.max


def default(kind: Any) -> Any:
    """What a field is before it is set."""
    node, detail = kind
    if node is Nodetype.BASE:
        known = {"string": "", "byte": b"\0", "bool": False}
        return known.get(detail[0], 0.0 if detail[0].startswith("float") else 0)
    if node is Nodetype.NAME:
        return message_type(detail)()
    (inner, name), count = detail
    if node is Nodetype.ARRAY and inner is Nodetype.BASE:
        return np.zeros(count, NUMBERS[name[0]])
    return array.array("B") if (inner, name) == (Nodetype.BASE, ("uint8", 0)) else []


TYPES: dict[str, type[Message]] = {}


def message_type(name: str) -> type[Message]:
    """The class of a message type, such as `sensor_msgs/msg/Image`."""
    if name not in TYPES:
        constants = {
            each: bytes([value]) if kind == "byte" else value for each, kind, value in STORE.fielddefs[name][0]
        }
        TYPES[name] = type(name.rpartition("/")[2], (Message,), {"NAME": name, **constants})
    return TYPES[name]


def stored(message: Message) -> Any:
    """A message as rosbags has it."""

    def convert(kind: Any, value: Any) -> Any:
        node, detail = kind
        if node is Nodetype.BASE:
            return value[0] if detail[0] == "byte" else value
        if node is Nodetype.NAME:
            return stored(value)
        inner = detail[0]
        if inner[0] is Nodetype.BASE and inner[1][0] in NUMBERS:
            held = np.frombuffer(value, np.uint8) if isinstance(value, bytes) else value
            return np.array(held, NUMBERS[inner[1][0]])
        return [convert(inner, each) for each in value]

    return STORE.types[message.NAME](
        **{name: convert(kind, getattr(message, name)) for name, kind in fields(message.NAME).items()}
    )


def loaded(kept: Any) -> Message:
    """A message of rosbags as rclpy has it."""

    def convert(kind: Any, value: Any) -> Any:
        node, detail = kind
        if node is Nodetype.NAME:
            return loaded(value)
        if node is Nodetype.BASE:
            return bytes([value]) if detail[0] == "byte" else value
        if isinstance(value, np.ndarray):
            if node is Nodetype.SEQUENCE:
                return array.array("B", value.tobytes()) if value.dtype == np.uint8 else value.tolist()
            return value.copy()
        return [convert(detail[0], each) for each in value]

    made = message_type(kept.__msgtype__)()
    for name, kind in fields(made.NAME).items():
        setattr(made, name, convert(kind, getattr(kept, name)))
    return made


def image(pixels: Any, encoding: str, padding: int = 0, big: bool = False) -> Any:
    """A message of an array as it is."""
    made = message_type("sensor_msgs/msg/Image")()
    made.height, made.width = pixels.shape[:2]
    made.encoding, made.is_bigendian = encoding, int(big)
    rows = pixels.astype(pixels.dtype.newbyteorder(">" if big else "<")).reshape(made.height, -1)
    made.step = rows.shape[1] * rows.itemsize + padding
    made.data = array.array("B", b"".join(row.tobytes() + b"\xee" * padding for row in rows))
    return made


def stamped(message: Any, time_s: float, frame: str) -> Any:
    """A message with its header."""
    message.header.frame_id = frame
    set_time(message.header.stamp, time_s)
    return message


def set_time(stamp: Any, time_s: float) -> None:
    """Set a `builtin_interfaces/Time`."""
    nanoseconds = round(time_s * 1e9)
    stamp.sec, stamp.nanosec = nanoseconds // 10**9, nanoseconds % 10**9


# rclpy


class Publisher:
    """Keeps what is published, once it went through CDR."""

    def __init__(self, node: LifecycleNode | None, kind: type[Message], qos: Any) -> None:
        self.node = node
        """Whose state counts; `None` for a publisher that is none of a lifecycle."""
        self.kind = kind
        self.qos = qos
        self.published: list[Any] = []
        self.bytes = 0
        self.came = threading.Event()

    def publish(self, message: Any) -> None:
        assert type(message) is self.kind
        if self.node is not None and self.node.state != "active":
            return
        sent = STORE.serialize_cdr(stored(message), message.NAME)
        self.bytes += len(sent)
        self.published.append(loaded(STORE.deserialize_cdr(sent, message.NAME)))
        self.came.set()


@dataclass
class Parameter:
    """As rclpy gives it."""

    name: str
    value: Any


class InvalidParameterValueException(Exception):
    """A parameter can't have this value."""


class LifecycleNode:
    """What the node takes from `rclpy.lifecycle.LifecycleNode`."""

    given: ClassVar[dict[str, Any]] = {}
    """Parameters that it is started with."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.state = "unconfigured"
        self.topics: dict[str, Publisher] = {}
        self.heard: dict[str, tuple[type, Callable[[Any], object], Any]] = {}
        self.offered: dict[str, Callable[[Any, Any], Any]] = {}
        self.ticking: list[Any] = []
        self.log: list[str] = []
        self.described: dict[str, Any] = {}
        self._values: dict[str, Any] = {}
        self._judges: list[Callable[[list[Parameter]], Any]] = []

    def get_name(self) -> str:
        return self.name

    # Parameters

    def add_on_set_parameters_callback(self, judge: Callable[[list[Parameter]], Any]) -> None:
        self._judges.append(judge)

    def declare_parameter(self, name: str, value: Any, descriptor: Any) -> None:
        self.described[name] = descriptor
        self._values[name] = value
        verdict = self.set_parameters([Parameter(name, self.given.get(name, value))])[0]
        if not verdict.successful:
            raise InvalidParameterValueException(verdict.reason)

    def set_parameters(self, changes: list[Parameter]) -> list[Any]:
        verdicts = []
        for change in changes:
            verdict = message_type("rcl_interfaces/msg/SetParametersResult")()
            verdict.successful = True
            for bounds in self.described[change.name].floating_point_range:
                if not bounds.from_value <= change.value <= bounds.to_value:
                    verdict.successful, verdict.reason = False, "out of range"
            if type(change.value) is not type(self._values[change.name]):
                verdict.successful, verdict.reason = False, "another type"
            for judge in self._judges:
                verdict = judge([change]) if verdict.successful else verdict
            if verdict.successful:
                self._values[change.name] = change.value
            verdicts.append(verdict)
        return verdicts

    def get_parameter(self, name: str) -> Parameter:
        return Parameter(name, self._values[name])

    # What it has

    def create_publisher(self, kind: type[Message], topic: str, qos: Any) -> Publisher:
        assert topic not in self.topics, f"{topic} wasn't destroyed"
        return self.topics.setdefault(topic, Publisher(None, kind, qos))

    def create_lifecycle_publisher(self, kind: type[Message], topic: str, qos: Any) -> Publisher:
        publisher = self.create_publisher(kind, topic, qos)
        publisher.node = self
        return publisher

    def create_subscription(self, kind: type, topic: str, callback: Callable[[Any], object], qos: Any) -> str:
        assert topic not in self.heard, f"{topic} wasn't destroyed"
        self.heard[topic] = (kind, callback, qos)
        return topic

    def create_service(self, kind: Any, name: str, answer: Callable[[Any, Any], Any], *, callback_group: Any) -> str:
        self.offered[name] = lambda: answer(kind.Request(), kind.Response())  # type: ignore[assignment]
        return name

    def create_timer(self, period_s: float, callback: Callable[[], object]) -> Any:
        timer = SimpleNamespace(period_s=period_s, callback=callback)
        self.ticking.append(timer)
        return timer

    def destroy_publisher(self, publisher: Publisher) -> None:
        self.topics = {topic: each for topic, each in self.topics.items() if each is not publisher}

    destroy_lifecycle_publisher = destroy_publisher

    def destroy_subscription(self, topic: str) -> None:
        del self.heard[topic]

    def destroy_service(self, name: str) -> None:
        del self.offered[name]

    def destroy_timer(self, timer: Any) -> None:
        self.ticking.remove(timer)

    def give(self, topic: str, message: Any) -> None:
        """What the executor does with a message of a topic."""
        kind, callback, _ = self.heard[topic]
        assert type(message) is kind
        callback(message)

    def tick(self) -> None:
        """Every timer, once."""
        for timer in list(self.ticking):
            timer.callback()

    def get_clock(self) -> Any:
        return SimpleNamespace(now=lambda: Time(nanoseconds=10**18))

    def get_logger(self) -> Any:
        def note(text: str, **_: object) -> None:
            self.log.append(text)

        return SimpleNamespace(error=note, warning=note, fatal=note, info=note)

    # States

    def on_activate(self, state: Any) -> str:
        return "success"

    def on_deactivate(self, state: Any) -> str:
        return "success"

    def change(self, transition: str) -> str:
        """What a call of `~/change_state` does; an exception is an error, which says nothing."""
        ends = {"configure": "inactive", "activate": "active", "deactivate": "inactive", "cleanup": "unconfigured"}
        before = self.state
        if transition == "activate":
            # Publishers are active by the end of the node's own callback.
            self.state = "active"
        done: str = getattr(self, f"on_{transition}")(before)
        self.state = ends.get(transition, "finalized") if done == "success" else before
        return done

    def destroy_node(self) -> None:
        pass


@dataclass(frozen=True)
class Time:
    """`rclpy.time.Time`."""

    nanoseconds: int = 0

    @classmethod
    def from_msg(cls, stamp: Any) -> Time:
        return cls(stamp.sec * 10**9 + stamp.nanosec)

    def __add__(self, span: Duration) -> Time:
        return Time(self.nanoseconds + round(span.seconds * 1e9))

    def to_msg(self) -> Any:
        stamp = message_type("builtin_interfaces/msg/Time")()
        set_time(stamp, self.nanoseconds / 1e9)
        return stamp


@dataclass(frozen=True)
class Duration:
    """`rclpy.duration.Duration`."""

    seconds: float = 0.0


# tf2_ros


class TransformException(Exception):
    """tf doesn't know."""


class Buffer:
    """A tree of transforms at the stamps that were given, without interpolation."""

    last: ClassVar[Buffer]

    def __init__(self) -> None:
        self.parents: dict[str, str] = {}
        self.poses: dict[tuple[str, int | None], Any] = {}
        Buffer.last = self

    def set_transform(self, transform: Any, static: bool = False) -> None:
        child = transform.child_frame_id
        self.parents[child] = transform.header.frame_id
        self.poses[child, None if static else Time.from_msg(transform.header.stamp).nanoseconds] = matrix(
            transform.transform
        )

    def _to_root(self, frame: str, time: Time | None) -> tuple[str, Any]:
        pose = np.eye(4)
        while frame in self.parents:
            if time is not None:
                known = self.poses.get((frame, None), self.poses.get((frame, time.nanoseconds)))
                if known is None:
                    raise TransformException(f"{frame} at {time}")
                pose = known @ pose
            frame = self.parents[frame]
        return frame, pose

    def can_transform(self, target: str, source: str, time: Time) -> bool:
        assert time == Time(), "the newest"
        known = self.parents.keys() | set(self.parents.values())
        return {target, source} <= known and self._to_root(target, None)[0] == self._to_root(source, None)[0]

    def lookup_transform(self, target: str, source: str, time: Time, timeout: Duration) -> Any:
        made = message_type("geometry_msgs/msg/TransformStamped")()
        pose = np.linalg.inv(self._to_root(target, time)[1]) @ self._to_root(source, time)[1]
        set_transform(made.transform, pose)
        return made


def matrix(transform: Any) -> Any:
    """4×4 of a `geometry_msgs/Transform`."""
    from landmarkd_ros.planar import rotation

    pose = np.eye(4)
    pose[:3, :3] = rotation(transform.rotation)
    at = transform.translation
    pose[:3, 3] = at.x, at.y, at.z
    return pose


def set_transform(transform: Any, pose: Any) -> None:
    """Set a `geometry_msgs/Transform` to a 4×4 matrix."""
    at, turn = transform.translation, transform.rotation
    at.x, at.y, at.z = map(float, pose[:3, 3])
    # The quaternion is the eigenvector of this matrix (Bar-Itzhack 2000).
    r = pose[:3, :3]
    k = np.array(
        [
            [r[0, 0] - r[1, 1] - r[2, 2], 0, 0, 0],
            [r[1, 0] + r[0, 1], r[1, 1] - r[0, 0] - r[2, 2], 0, 0],
            [r[2, 0] + r[0, 2], r[2, 1] + r[1, 2], r[2, 2] - r[0, 0] - r[1, 1], 0],
            [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], r.trace()],
        ]
    )
    turn.x, turn.y, turn.z, turn.w = map(float, np.linalg.eigh(k)[1][:, -1])


OPTICAL = np.array([[0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]], float)
"""`T_body_optical`: the optical frame's z is the body's x."""


def placed(x_m: float, y_m: float, yaw: float, z_m: float = 0.0) -> Any:
    """4×4 of a body on the plane, yaw in radians."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    return np.array([[cos, -sin, 0, x_m], [sin, cos, 0, y_m], [0, 0, 1, z_m], [0, 0, 0, 1]])


def transform(parent: str, child: str, pose: Any, time_s: float = 0.0) -> Any:
    """`T_parent_child` as a message."""
    made = stamped(message_type("geometry_msgs/msg/TransformStamped")(), time_s, parent)
    made.child_frame_id = child
    set_transform(made.transform, pose)
    return made


class TransformBroadcaster:
    """Publishes on /tf."""

    def __init__(self, node: LifecycleNode) -> None:
        self.pub_tf = node.create_publisher(message_type("tf2_msgs/msg/TFMessage"), "/tf", 100)

    def sendTransform(self, transform: Any) -> None:  # noqa: N802
        message = self.pub_tf.kind()
        message.transforms = [transform]
        self.pub_tf.publish(message)


# message_filters


class Synchronizer:
    """Calls back with what the test gives it, as if it had come at one time."""

    def __init__(self, subscribers: list[Any], queue_size: int, slop: float) -> None:
        self.topics = [subscriber.sub for subscriber in subscribers]

    def registerCallback(self, callback: Callable[..., object]) -> None:  # noqa: N802
        self.give = callback


@dataclass
class QoSProfile:
    """`rclpy.qos.QoSProfile`."""

    depth: int
    reliability: str = "reliable"
    durability: str = "volatile"


@dataclass
class Response:
    """`std_srvs/srv/Trigger_Response`, which isn't among the definitions of rosbags."""

    success: bool = False
    message: str = field(default="")


def install() -> None:
    """Let `import rclpy` and the others find these."""

    def subscriber(node: LifecycleNode, kind: type, topic: str, qos_profile: object) -> Any:
        return SimpleNamespace(sub=node.create_subscription(kind, topic, lambda message: None, qos_profile))

    modules: dict[str, dict[str, Any]] = {
        "rclpy": {"init": None, "try_shutdown": None},
        "rclpy.callback_groups": {"MutuallyExclusiveCallbackGroup": object},
        "rclpy.duration": {"Duration": Duration},
        "rclpy.executors": {
            "ExternalShutdownException": type("ExternalShutdownException", (Exception,), {}),
            "MultiThreadedExecutor": object,
        },
        "rclpy.lifecycle": {
            "LifecycleNode": LifecycleNode,
            "LifecycleState": str,
            "TransitionCallbackReturn": SimpleNamespace(SUCCESS="success", FAILURE="failure", ERROR="error"),
        },
        "rclpy.qos": {
            "QoSProfile": QoSProfile,
            "ReliabilityPolicy": SimpleNamespace(RELIABLE="reliable", BEST_EFFORT="best effort"),
            "DurabilityPolicy": SimpleNamespace(TRANSIENT_LOCAL="transient local", VOLATILE="volatile"),
            "qos_profile_sensor_data": QoSProfile(5, "best effort"),
        },
        "rclpy.time": {"Time": Time},
        "tf2_ros": {
            "Buffer": Buffer,
            "TransformBroadcaster": TransformBroadcaster,
            "TransformException": TransformException,
            "TransformListener": lambda buffer, node: SimpleNamespace(unregister=lambda: None),
        },
        "message_filters": {"Subscriber": subscriber, "ApproximateTimeSynchronizer": Synchronizer},
        "std_srvs": {},
        "std_srvs.srv": {"Trigger": SimpleNamespace(Request=SimpleNamespace, Response=Response)},
    }
    for name in STORE.fielddefs:
        package, _, kind = name.split("/")
        modules.setdefault(package, {})
        modules.setdefault(f"{package}.msg", {})[kind] = message_type(name)
    for name, held in modules.items():
        module = ModuleType(name)
        vars(module).update(held)
        sys.modules[name] = module
        parent, _, child = name.rpartition(".")
        if parent:
            setattr(sys.modules[parent], child, module)
