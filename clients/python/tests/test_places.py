"""Poses and cameras with the real service."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest
from drawing import moved, room
from fixtures import ROOMS

from landmarkd import Camera, Client, MapPose, Odometry, PlacePose, Problem
from landmarkd.event import Event

CAMERA = Camera(150, 150, 79.5, 79.5, 160, 160)


@pytest.fixture(scope="module")
def hall(client: Client) -> Iterator[str]:
    """Three rooms 2 m apart, seen along y."""
    client.keep_camera("front", CAMERA)
    client.create("hall")
    for number, label in enumerate(ROOMS):
        client.teach(
            "hall", label, room(number), pose=MapPose("hall", 2.0 * number, 1, 90, sigma_m=0.1), camera="front"
        )
    client.train("hall")
    yield "hall"
    client.forget_camera("front")


def test_cameras_are_kept(client: Client, hall: str) -> None:
    assert client.camera("front") == CAMERA
    assert "front" in list(client.cameras())
    with pytest.raises(Problem) as caught:
        client.recognise(hall, room(0), camera="nowhere")
    assert caught.value.status in (404, 422)


@pytest.mark.parametrize("camera", ["front", CAMERA, None])
def test_a_place_is_where_its_exemplar_was_taken(client: Client, hall: str, camera: Camera | str | None) -> None:
    answer = client.recognise(hall, moved(room(1), 2, 1), camera=camera)
    assert isinstance(answer.pose, PlacePose)
    assert answer.pose.map == "hall"
    assert (answer.pose.x_m, answer.pose.y_m) == pytest.approx((2, 1), abs=0.5)
    assert answer.pose.yaw_deg == pytest.approx(90, abs=5)
    assert len(answer.pose.covariance) == 9
    assert answer.pose.support


def test_frames_without_a_known_place_have_no_pose(client: Client, hall: str) -> None:
    assert client.recognise(hall, room(50), camera="front").pose is None


def test_a_track_tells_a_pose_by_all_of_its_frames(client: Client, hall: str) -> None:
    with client.track(hall, motion="still") as track:
        frames = [track.frame(moved(room(1), step, 0), camera="front", odometry=Odometry(0, 0, 0)) for step in range(4)]
    pose = frames[-1].pose
    assert isinstance(pose, PlacePose)
    assert not pose.lost
    assert (pose.x_m, pose.y_m) == pytest.approx((2, 1), abs=0.5)


def test_decisions_are_events(client: Client, hall: str) -> None:
    heard: list[Event] = []
    came = threading.Event()

    def listen() -> None:
        with Client(client.url) as follower:
            for event in follower.events(database=hall, robot_id="r7", kinds=["decision"]):
                heard.append(event)
                came.set()
                return

    threading.Thread(target=listen, daemon=True).start()
    with Client(client.url, robot_id="r7") as robot:
        for _ in range(50):
            robot.recognise(hall, room(2), camera="front", frame_id="9")
            if came.wait(0.1):
                break
    assert heard
    assert (heard[0].kind, heard[0].data["header"]["robot_id"]) == ("decision", "r7")
    assert heard[0].data["decision"]["label"] == ROOMS[2]
    assert PlacePose.of(heard[0].data["pose"]).x_m == pytest.approx(4, abs=0.5)
