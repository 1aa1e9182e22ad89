"""A recorded drive played through the node: the bag is written and read by `rosbags`, the pictures are drawn here.

With `-s` it prints what went in and out, and what it cost.
"""

from __future__ import annotations

import array
import io
import math
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import ros
from drawing import room
from fixtures import ROOMS
from PIL import Image
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin, Writer
from service import Service
from test_node import OPTICAL, Start, published, start, values, waited

from landmarkd import Camera, Client, MapPose
from landmarkd_ros import images

__all__ = ["start"]

FRAMES = 18
SIDE_PX = 320
CAMERA = Camera(270, 270, 160, 160, SIDE_PX, SIDE_PX)
TOPICS = {
    "bgr8": "/camera/image_raw",
    "bayer_rggb8": "/raw_camera/image_raw",
    "jpeg": "/camera/image_raw/compressed",
}


def coloured(number: int, step: int) -> np.ndarray:
    """A room seen by a camera that sidles: its boxes are of three colours."""
    channels = [room(10 * number + channel, SIDE_PX) for channel in range(3)]
    return np.roll(np.dstack(channels), (step % 5, 2 * (step % 7)), (0, 1))


def raw(pixels: np.ndarray, encoding: str) -> Any:
    """A picture as a driver sends it."""
    if encoding == "bgr8":
        return ros.image(pixels[:, :, ::-1], encoding)
    if encoding == "bayer_rggb8":
        mosaic = np.zeros(pixels.shape[:2], np.uint8)
        for place, colour in enumerate((0, 1, 1, 2)):
            at = np.s_[place // 2 :: 2, place % 2 :: 2]
            mosaic[at] = pixels[(*at, colour)]
        return ros.image(mosaic, encoding)
    held = io.BytesIO()
    Image.fromarray(pixels).save(held, "JPEG", quality=90)
    made = ros.message_type("sensor_msgs/msg/CompressedImage")()
    made.format, made.data = "rgb8; jpeg compressed bgr8", array.array("B", held.getvalue())
    return made


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A robot that drives past three rooms, with three cameras, a description of them, and tf."""
    path = tmp_path_factory.mktemp("bag") / "drive"
    info = ros.message_type("sensor_msgs/msg/CameraInfo")()
    info.width = info.height = SIDE_PX
    info.distortion_model, info.d = "plumb_bob", [0.0] * 5
    info.k = np.array([CAMERA.fx, 0, CAMERA.cx, 0, CAMERA.fy, CAMERA.cy, 0, 0, 1], float)
    mount = ros.transform("base_link", OPTICAL, ros.placed(0.2, 0.0, 0.0, 0.4) @ ros.OPTICAL)
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        known: dict[str, Any] = {}

        def write(topic: str, message: Any, time_s: float) -> None:
            if topic not in known:
                known[topic] = writer.add_connection(topic, message.NAME, typestore=ros.STORE)
            writer.write(known[topic], round(time_s * 1e9), ros.STORE.serialize_cdr(ros.stored(message), message.NAME))

        for number in range(FRAMES):
            time_s = 100 + number / 10
            pixels = coloured(number * len(ROOMS) // FRAMES, number)
            odom = ros.transform("odom", "base_link", ros.placed(0.1 * number, 0, 0.01 * number), time_s)
            for topic, transform in (("/tf_static", mount), ("/tf", odom)):
                message = ros.message_type("tf2_msgs/msg/TFMessage")()
                message.transforms = [transform]
                write(topic, message, time_s)
            write("/camera/camera_info", ros.stamped(info, time_s, OPTICAL), time_s)
            for encoding, topic in TOPICS.items():
                write(topic, ros.stamped(raw(pixels, encoding), time_s, OPTICAL), time_s)
    return path


@pytest.fixture(scope="module")
def drive(client: Client) -> str:
    """A database that knows the three rooms."""
    client.create("drive")
    for number, label in enumerate(ROOMS):
        for step in (0, 3):
            pose = MapPose("hall", 3.0 * number, 0.0, 0.0, sigma_m=0.1)
            client.teach("drive", label, coloured(number, step), pose=pose, camera=CAMERA)
    client.train("drive")
    return "drive"


def messages(bag: Path, topic: str) -> Iterator[tuple[str, Any]]:
    """What a node that listens to a camera gets of a bag, in its order."""
    with AnyReader([bag], default_typestore=ros.STORE) as reader:
        heard = [
            each for each in reader.connections if each.topic in {topic, "/tf", "/tf_static", "/camera/camera_info"}
        ]
        for connection, _, data in reader.messages(heard):
            yield connection.topic, ros.loaded(reader.deserialize(data, connection.msgtype))


def play(node: Any, topic: str, message: Any) -> None:
    """Hand a message of the bag to the node, as its remappings would."""
    if topic in {"/tf", "/tf_static"}:
        for each in message.transforms:
            ros.Buffer.last.set_transform(each, static=topic == "/tf_static")
    elif topic == "/camera/camera_info":
        node.give("camera_info", message)
    else:
        node.give("image/compressed" if "compressed" in topic else "image", message)


@pytest.mark.parametrize("encoding", TOPICS)
def test_every_picture_of_a_bag_is_answered(
    start: Start, service: Service, bag: Path, drive: str, client: Client, encoding: str
) -> None:
    topic = TOPICS[encoding]
    transport = "compressed" if encoding == "jpeg" else "raw"
    # One by one: the bag's frames jump from room to room.
    node = start(
        service.url,
        database=drive,
        image_transport=transport,
        base_frame="base_link",
        tracked=False,
        # However busy the machine is.
        timeout_s=30.0,
    )
    played = list(messages(bag, topic))
    node_ms, call_ms, cpu_ms = [], [], 0.0
    came = node.topics["detections"].came
    for at, message in played:
        came.clear()
        cpu_s, asked_s = time.process_time(), time.perf_counter()
        play(node, at, message)
        if at != topic:
            continue
        assert came.wait(40), (node.log, values(node))
        node_ms.append(1000 * (time.perf_counter() - asked_s))
        cpu_ms += 1000 * (time.process_time() - cpu_s)
        picture, asked_s = images.picture(message), time.perf_counter()
        client.recognise(drive, picture, camera=CAMERA)
        call_ms.append(1000 * (time.perf_counter() - asked_s))
    waited(lambda: node.health.answered == FRAMES, node)
    out = {name: len(publisher.published) for name, publisher in node.topics.items() if publisher.published}
    size = sum(publisher.bytes for publisher in node.topics.values())
    print(
        f"\n{encoding}: {len(played)} messages in, of them {FRAMES} pictures; out {out}, {size} bytes of CDR; "
        f"CPU of the node {cpu_ms / FRAMES:.1f} ms a picture; "
        f"node p50 {np.median(node_ms):.1f} ms, p95 {np.percentile(node_ms, 95):.1f} ms; "
        f"plain call p50 {np.median(call_ms):.1f} ms, p95 {np.percentile(call_ms, 95):.1f} ms"
    )
    assert {name: out[name] for name in ("place", "decision", "detections")} == dict.fromkeys(
        ("place", "decision", "detections"), FRAMES
    )
    assert (node.health.frames_in, node.health.asked, node.health.dropped) == (FRAMES, FRAMES, 0)
    stamps = [math.fsum((each.header.stamp.sec, each.header.stamp.nanosec / 1e9)) for each in published(node, "place")]
    assert stamps == pytest.approx([100 + number / 10 for number in range(FRAMES)])
    # The camera sits 0.2 m ahead of the base.
    poses = [each.pose.pose.position.x for each in published(node, "pose")]
    assert poses == pytest.approx([3.0 * (number * len(ROOMS) // FRAMES) - 0.2 for number in range(FRAMES)], abs=0.3)
    decided = Counter(each.results[0].class_id for each in published(node, "decision") if each.results)
    # A belief lags a frame or two behind where a robot turns into another room.
    assert all(decided[label] >= FRAMES // len(ROOMS) - 3 for label in ROOMS), decided
    assert sum(len(each.detections) for each in published(node, "detections")) >= FRAMES - 5


def test_a_camera_that_is_too_fast_is_counted(start: Start, service: Service, bag: Path, drive: str) -> None:
    node = start(service.url, database=drive, odom_frame="", timeout_s=30.0)
    for at, message in messages(bag, TOPICS["bgr8"]):
        if at == TOPICS["bgr8"]:
            play(node, at, message)
    waited(lambda: node.health.answered + node.health.dropped == FRAMES, node, 40)
    assert node.health.dropped > 0
    assert published(node, "place")[-1].header.stamp.nanosec == 700_000_000
    assert values(node)["frames_in"] == str(FRAMES)
