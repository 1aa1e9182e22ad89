"""The node with stand-ins of ROS, against the real service; against a stub where that tells poses or refuses."""

from __future__ import annotations

import array
import io
import json
import math
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
import ros
from drawing import blurred, moved, room, texture
from fixtures import teach_rooms
from PIL import Image
from service import BINARY, Service
from stub import Answer, Stub, began, recognition, refusal, tracked, version

from landmarkd import Client
from landmarkd.planar import Planar
from landmarkd_ros.node import LandmarkdNode
from landmarkd_ros.parameters import PARAMETERS

OPTICAL = "camera_optical_frame"
Start = Callable[..., Any]


@pytest.fixture
def start(monkeypatch: pytest.MonkeyPatch) -> Iterator[Start]:
    """Makes nodes with parameters, active unless said otherwise."""
    made = []

    def start(url: str, *transitions: str, **parameters: Any) -> Any:
        given = {"service": url, "motion": "still", "timeout_s": 10.0, "base_frame": ""} | parameters
        monkeypatch.setattr(ros.LifecycleNode, "given", given)
        node = LandmarkdNode()
        made.append(node)
        for transition in transitions or ("configure", "activate"):
            assert node.change(transition) == "success", node.log
        return node

    yield start
    for node in made:
        node.destroy_node()
        assert not node.topics
        assert not node.heard
        assert not node.offered
        assert not node.ticking


def taken(pixels: np.ndarray, time_s: float) -> Any:
    return ros.stamped(ros.image(pixels, "mono8"), time_s, OPTICAL)


def waited(true: Callable[[], object], node: Any, seconds: float = 10) -> None:
    """Wait until something is so."""
    ends = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < ends, (node.log, values(node))
        time.sleep(0.001)


def published(node: Any, topic: str) -> list[Any]:
    return list(node.topics[topic].published)


def see(node: Any, message: Any) -> None:
    """Give a picture, and wait for what comes of it."""
    before = node.health.answered
    node.give("image", message)
    waited(lambda: node.health.answered > before, node)


def values(node: Any) -> dict[str, str]:
    """What diagnostics say."""
    status = node.health.status()
    return {pair.key: pair.value for pair in status.values} | {"level": status.level, "message": status.message}


def odometry(base: Planar, time_s: float) -> None:
    """What tf knows of a robot whose camera sits 0.4 m ahead of its base and looks to the left, 0.5 m up."""
    ros.Buffer.last.set_transform(ros.transform("odom", "base_link", ros.placed(base.x_m, base.y_m, base.yaw), time_s))
    mount = ros.placed(0.4, 0.1, math.pi / 2, 0.5) @ ros.OPTICAL
    ros.Buffer.last.set_transform(ros.transform("base_link", OPTICAL, mount), static=True)


# Places and things


def test_places_are_published(start: Start, service: Service, home: str) -> None:
    node = start(service.url, database=home)
    for number in range(3):
        see(node, taken(moved(room(1), number, 0), number + 1.25))
    place, decision, detections = (published(node, name)[-1] for name in ("place", "decision", "detections"))
    assert place.results[0].class_id == decision.results[0].class_id == "stairs"
    assert (place.header.frame_id, place.header.stamp.sec, place.header.stamp.nanosec) == (OPTICAL, 3, 250_000_000)
    assert detections.detections[0].results[0].hypothesis.class_id == "stairs"
    box = detections.detections[0].bbox
    assert (box.size_x, box.size_y) == (pytest.approx(160, abs=8), pytest.approx(160, abs=8))
    assert node.topics["place"].qos.durability == "transient local"
    assert node.heard["image"][2].reliability == "best effort"


def test_a_compressed_picture_goes_to_the_service_as_it_is(start: Start) -> None:
    stub = Stub(lambda method, path: recognition("stairs") if method == "POST" else version())
    try:
        node = start(stub.url, image_transport="compressed", tracked=False)
        held = io.BytesIO()
        Image.fromarray(room(1)).save(held, "JPEG")
        message = ros.stamped(ros.message_type("sensor_msgs/msg/CompressedImage")(), 1, OPTICAL)
        message.format, message.data = "mono8; jpeg compressed", array.array("B", held.getvalue())
        node.give("image/compressed", message)
        waited(lambda: published(node, "place"), node)
    finally:
        stub.stop()
    assert [each.body for each in stub.requests if each.method == "POST"] == [held.getvalue()]


def test_an_encoding_that_is_not_read_is_said(start: Start, service: Service, home: str) -> None:
    node = start(service.url, database=home)
    message = taken(room(0), 1)
    message.encoding = "nv21"
    node.give("image", message)
    waited(lambda: "nv21" in values(node)["last_problem"], node)
    see(node, taken(room(0), 2))
    assert values(node)["last_problem"] == ""


# States and parameters


def test_only_an_active_node_asks(start: Start, service: Service, home: str) -> None:
    node = start(service.url, "configure", database=home)
    node.give("image", taken(room(0), 1))
    time.sleep(0.2)
    assert (node.health.frames_in, published(node, "place")) == (0, [])
    assert values(node)["message"] == "inactive"
    node.change("activate")
    see(node, taken(room(0), 2))
    node.change("deactivate")
    node.give("image", taken(room(0), 3))
    time.sleep(0.2)
    assert len(published(node, "place")) == 1
    for transition in ("cleanup", "configure", "activate"):
        assert node.change(transition) == "success"
    see(node, taken(room(0), 4))
    assert node.change("shutdown") == "success"
    assert node.heard == {}


def test_what_can_not_be_configured_is_refused(start: Start) -> None:
    node = start("http://127.0.0.1:9", "configure", "cleanup")
    node.set_parameters([ros.Parameter("local_binary", "/usr/bin/landmarkd")])
    assert node.change("configure") == "failure"
    assert "keep" in node.log[-1]
    node.set_parameters([ros.Parameter("local_binary", "")])
    assert node.change("configure") == "success"


def test_parameters_say_what_they_are_and_refuse_what_can_not_be(start: Start) -> None:
    node = start("http://127.0.0.1:9")
    assert node.described.keys() == PARAMETERS.keys()
    assert all(each.description.endswith(".") for each in node.described.values())

    def set_to(name: str, value: Any) -> str:
        verdict = node.set_parameters([ros.Parameter(name, value)])[0]
        assert verdict.successful == (verdict.reason == "")
        return verdict.reason

    assert set_to("max_rate_hz", 4.0) == set_to("label", "kitchen") == set_to("publish_tf", True) == ""
    assert "always" in set_to("promote", "sometimes")
    assert set_to("max_rate_hz", -1.0) != ""
    assert "clean it up" in set_to("database", "other")
    node.change("deactivate")
    node.change("cleanup")
    assert set_to("database", "other") == ""
    with pytest.raises(ros.InvalidParameterValueException, match="raw, compressed"):
        start("http://127.0.0.1:9", image_transport="theora")


def test_the_rate_is_held(start: Start) -> None:
    stub = Stub(lambda method, path: recognition("stairs") if method == "POST" else version())
    try:
        node = start(stub.url, tracked=False, max_rate_hz=5.0)
        ends = time.monotonic() + 1.0
        while time.monotonic() < ends:
            node.give("image", taken(room(0), 1))
            time.sleep(0.01)
    finally:
        stub.stop()
    assert 3 <= node.health.asked <= 6
    assert node.health.frames_in > 40


# Poses


def posed(x_m: float, y_m: float, yaw_deg: float, lost: bool = False) -> dict[str, Any]:
    covariance = [0.04, 0, 0, 0, 0.09, 0, 0, 0, 0.01]
    pose = {"map": "map", "x_m": x_m, "y_m": y_m, "yaw_deg": yaw_deg, "covariance": covariance, "method": "filter"}
    return pose | {"support": [], "lost": lost}


@pytest.fixture
def posing() -> Iterator[tuple[Stub, list[dict[str, Any] | None]]]:
    """A stub whose frames have these poses, one after the other."""
    poses: list[dict[str, Any] | None] = []

    def answer(method: str, path: str) -> Answer:
        if method == "DELETE":
            return 204, {}, {}
        if path.endswith("/tracks"):
            return began()
        if path.endswith("/frames"):
            return tracked("stairs", 1, pose=poses.pop(0) if poses else None)
        return version()

    stub = Stub(answer)
    yield stub, poses
    stub.stop()


def test_the_pose_of_the_base_is_published_and_nav2_is_told_once(start: Start, posing: Any) -> None:
    stub, poses = posing
    node = start(stub.url, base_frame="base_link", initialpose=True, publish_tf=True)
    # The camera is seen where it is when the base is at (1, 2) and heads along y; odometry has drifted.
    poses += [posed(0.9, 2.4, 180.0), posed(0.9, 2.4, 180.0), posed(0, 0, 0, lost=True), posed(0.9, 2.4, 180.0)]
    for number in range(1, 5):
        odometry(Planar(0.5, 0.0, 0.1), number)
        see(node, taken(room(1), number))
    poses_out, initial = published(node, "pose"), published(node, "/initialpose")
    assert [each.header.stamp.sec for each in poses_out] == [1, 2, 4]
    assert [each.header.stamp.sec for each in initial] == [1, 4]
    pose = poses_out[0].pose.pose
    assert (pose.position.x, pose.position.y) == pytest.approx((1.0, 2.0))
    assert 2 * math.atan2(pose.orientation.z, pose.orientation.w) == pytest.approx(math.pi / 2)
    assert poses_out[0].header.frame_id == "map"
    # The base is 0.41 m off the camera, so that the doubt about yaw is added to that of its position.
    covariance = poses_out[0].pose.covariance.reshape(6, 6)
    assert covariance[0, 0] == pytest.approx(0.04 + 0.01 * 0.4**2)
    assert covariance[1, 1] == pytest.approx(0.09 + 0.01 * 0.1**2)
    # map→odom brings the odometry's pose to the one that was seen, and is said again by the timer.
    node.tick()
    sent = published(node, "/tf")[-1].transforms[0]
    assert (sent.header.frame_id, sent.child_frame_id) == ("map", "odom")
    base = ros.matrix(sent.transform) @ ros.placed(0.5, 0.0, 0.1)
    assert base == pytest.approx(ros.placed(1.0, 2.0, math.pi / 2), abs=1e-9)


def test_odometry_of_the_camera_goes_with_the_frames(start: Start, posing: Any) -> None:
    stub, _ = posing
    node = start(stub.url)
    # A quarter turn on the spot to the left swings the camera, which then looks another way.
    for number, base in enumerate([Planar(0, 0, 0), Planar(0, 0, math.pi / 2), None, Planar(1, 0, 0)]):
        if base is not None:
            odometry(base, number + 1)
        see(node, taken(room(1), number + 1))
    queries = [each.query for each in stub.requests if each.path.endswith("/frames")]
    assert ["dx_m" in each for each in queries] == [False, True, False, False]
    # From (0.4, 0.1) to (-0.1, 0.4), in a frame that looks along y.
    step = [float(queries[1][name]) for name in ("dx_m", "dy_m", "dyaw_deg")]
    assert step == pytest.approx([0.3, 0.5, 90.0])


def test_no_pose_is_told_before_tf_knows_the_mount(start: Start, posing: Any) -> None:
    stub, poses = posing
    node = start(stub.url, base_frame="base_link")
    poses += [posed(1, 2, 3)]
    see(node, taken(room(1), 1))
    assert published(node, "pose") == []
    assert "base_link" in node.log[-1]


def test_without_odometry_the_base_hangs_on_the_map(start: Start, posing: Any) -> None:
    stub, poses = posing
    node = start(stub.url, odom_frame="", publish_tf=True)
    poses += [posed(1, 2, 30)]
    see(node, taken(room(1), 1))
    sent = published(node, "/tf")[0].transforms[0]
    assert (sent.header.frame_id, sent.child_frame_id) == ("map", f"{OPTICAL}_body")
    assert (sent.transform.translation.x, sent.header.stamp.sec) == (1, 1)
    assert all("dx_m" not in each.query for each in stub.requests)


def test_the_camera_goes_with_the_picture(start: Start, posing: Any) -> None:
    stub, _ = posing
    node = start(stub.url)
    info = ros.message_type("sensor_msgs/msg/CameraInfo")()
    info.width, info.height, info.distortion_model = 160, 160, "plumb_bob"
    info.k = np.array([150.0, 0, 80, 0, 150, 80, 0, 0, 1])
    node.give("camera_info", info)
    see(node, taken(room(1), 1))
    form = next(each.body for each in stub.requests if each.path.endswith("/frames"))
    assert json.loads(form.partition(b'name="camera"')[2].split(b"\r\n\r\n")[1].partition(b"\r\n")[0])["fx"] == 150


# Going on


def test_it_goes_on_once_a_database_is_trained(start: Start, client: Client, service: Service) -> None:
    client.create("later")
    node = start(service.url, database="later", label="kitchen", promote="always")
    node.give("image", taken(room(0), 1))
    waited(lambda: "not_trained" in values(node)["last_problem"], node)
    assert values(node)["reachable"] == "True"
    taught = node.offered["~/teach"]()
    assert taught.success, taught.message
    assert "without a pose" in taught.message
    trained = node.offered["~/train"]()
    assert (trained.success, trained.message) == (True, "version 1")
    give_until_answered(node)
    assert published(node, "decision")


def give_until_answered(node: Any) -> None:
    """As a camera goes on: what comes before the next attempt is due is dropped."""
    before = node.health.answered

    def answered() -> bool:
        node.give("image", taken(room(0), 9))
        time.sleep(0.05)
        return bool(node.health.answered > before)

    waited(answered, node)
    assert node.health.frames_in >= node.health.answered + node.health.dropped


def test_it_goes_on_after_503_and_an_expired_track(start: Start) -> None:
    refusals = [refusal(503, "overloaded", "1"), refusal(404, "unknown_track"), refusal(401, "bad_key")]
    beginnings = []

    def answer(method: str, path: str) -> Answer:
        if path.endswith("/tracks"):
            beginnings.append(path)
            return began()
        if path.endswith("/frames"):
            return refusals.pop(0) if refusals else tracked("stairs", 1)
        return version()

    stub = Stub(answer)
    try:
        node = start(stub.url)
        give_until_answered(node)
    finally:
        stub.stop()
    assert not refusals
    assert len(beginnings) == 2
    assert values(node)["level"] == b"\0"


def test_it_goes_on_after_a_restart(start: Start, folder: Path) -> None:
    first = Service(folder)
    with Client(first.url) as client:
        client.create("home")
        client.teach("home", "kitchen", room(0))
        client.teach("home", "stairs", room(1))
        client.train("home")
    node = start(first.url)
    see(node, taken(room(0), 1))
    first.kill()
    node.give("image", taken(room(0), 2))
    waited(lambda: values(node)["reachable"] == "False", node)
    assert values(node)["level"] == b"\2"
    second = Service(folder, first.port)
    try:
        give_until_answered(node)
        assert published(node, "decision")[-1].results[0].class_id == "kitchen"
    finally:
        second.stop()


def test_a_local_service_answers_while_the_real_one_is_away(start: Start, folder: Path, tmp_path: Path) -> None:
    fleet = Service(folder)
    with Client(fleet.url) as client:
        teach_rooms(client, "home")
    node = start(fleet.url, keep=str(tmp_path), local_binary=BINARY)
    see(node, taken(room(0), 1))
    waited(lambda: list(tmp_path.rglob("*.safetensors")), node)
    fleet.kill()
    give_until_answered(node)
    assert values(node) | {"source": "local", "reachable": "False", "level": b"\1"} == values(node)
    assert published(node, "decision")[-1].results[0].class_id == "kitchen"


# Teaching and diagnostics


def test_what_is_taught_has_the_pose_that_tf_knows(start: Start, posing: Any) -> None:
    stub, _ = posing
    node = start(stub.url, "configure", label="")
    assert "label" in node.offered["~/teach"]().message
    node.set_parameters([ros.Parameter("label", "stairs")])
    assert "no picture" in node.offered["~/teach"]().message
    odometry(Planar(0, 0, 0), 5)
    ros.Buffer.last.set_transform(ros.transform("map", "odom", ros.placed(1, 2, math.pi), 5))
    node.give("image", taken(room(1), 5))
    # The stub's answer is no exemplar, which is said; what was asked counts.
    assert "unexpected answer" in node.offered["~/teach"]().message
    query = next(each.query for each in stub.requests if each.path.endswith("/exemplars"))
    sent = [float(query[name]) for name in ("x_m", "y_m", "z_m", "pitch_deg", "roll_deg")]
    assert sent == pytest.approx([0.6, 1.9, 0.5, 0, 0], abs=1e-9)
    assert float(query["yaw_deg"]) == pytest.approx(-90)
    assert (query["label"], query["map"]) == ("stairs", "map")


def test_diagnostics_tell_how_it_does(start: Start, service: Service, home: str) -> None:
    node = start(service.url, database=home, robot_id="r7")
    see(node, taken(room(1), 1))
    node.tick()
    (status,) = published(node, "/diagnostics")[-1].status
    said = {pair.key: pair.value for pair in status.values}
    assert (status.level, status.name, status.hardware_id) == (b"\0", "landmarkd: recognition", "r7")
    assert (said["frames_in"], said["asked"], said["answered"], said["dropped"]) == ("1", "1", "1", "0")
    assert said["release"] == "0.1.0"
    assert float(said["latency_ms"]) > 0


# Distances


def test_distances_are_published_in_metres(start: Start, service: Service, home: str, client: Client) -> None:
    optics = {
        "focal_length_mm": 35,
        "f_number": 8,
        "near_focus_mm": 500,
        "plane_separation_mm": 0.4,
        "pixel_pitch_um": 10,
        "telecentric": True,
    }
    httpx.put(f"{service.url}/v1/calibrations/rig", json=optics).raise_for_status()
    node = start(service.url, database=home, calibration="rig")
    plane = texture(1)
    near, far = blurred(plane, 1.2), blurred(plane, 1.0)
    info = ros.message_type("sensor_msgs/msg/CameraInfo")()
    info.width = 160
    node.give("near/camera_info", info)
    assert node.distances.pair.topics == ["near", "far"]
    node.distances.pair.give(taken(near, 7), taken(far, 7))
    waited(lambda: published(node, "depth/camera_info"), node)
    image = published(node, "depth/image")[0]
    metres = np.frombuffer(image.data, np.float32).reshape(image.height, image.width)
    depth = client.depth(near, far, calibration="rig")
    assert np.array_equal(metres, depth.depth_mm / np.float32(1000), equal_nan=True)
    described = published(node, "depth/camera_info")[0]
    assert (image.encoding, image.header.stamp.sec) == ("32FC1", 7)
    assert (described.width, described.header.stamp.sec) == (160, 7)
