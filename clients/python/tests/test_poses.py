"""Poses and cameras: what is sent, and what is made of the answers, against a stub."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import pytest
from drawing import room
from stub import Answer, Request, Stub, began, recognition, tracked

from landmarkd import Camera, Client, LandmarkPose, MapPose, Odometry, PlacePose

CAMERA = Camera(500, 501, 320, 240, 640, 480, k1=-0.1)
POSE = {
    "map": "hall", "x_m": 1.5, "y_m": -2.0, "yaw_deg": 90.0, "method": "two_view", "support": ["a", "b"],
    "covariance": [0.04, 0, 0, 0, 0.04, 0, 0, 0, 0.01],
}  # fmt: skip
SOLUTION = {"translation_m": [0.1, 0, 2], "quaternion": [0, 0, 0, 1], "covariance": [0.0] * 36, "error_px": 0.3}
EXEMPLAR = {
    "id": "00000000-0000-0000-0000-000000000002", "label": "kitchen", "negative": False, "width_px": 160,
    "height_px": 160, "bytes": 9, "sha256": "s", "media_type": "image/png", "created_at": "2026-01-01T00:00:00Z",
    "header": {},
}  # fmt: skip


@pytest.fixture
def stub() -> Iterator[Stub]:
    placement = {
        "x_px": 1.0, "y_px": 2.0, "rotation_deg": 0.0, "scale": 1.0, "inliers": 9, "outline_px": [[0, 0]] * 4,
        "exemplar": "e", "agreement": 0.5, "T_camera_landmark": SOLUTION, "ambiguous": True,
        "alternative": SOLUTION | {"error_px": 0.4},
    }  # fmt: skip

    def answer(method: str, path: str) -> Answer:
        if path == "/v1/cameras":
            names = [{"name": "front", **CAMERA.body()}, {"name": "rear", **CAMERA.body()}]
            return 200, {"items": names, "next_cursor": None}, {}
        if path.startswith("/v1/cameras/"):
            return 200, CAMERA.body() | {"name": "front", "updated_at": "2026-01-01T00:00:00Z"}, {}
        if path.endswith("/exemplars"):
            return 201, EXEMPLAR, {}
        if path.endswith("/tracks"):
            return began()
        if method == "DELETE":
            return 204, {}, {}
        if path.endswith("/frames"):
            return tracked("kitchen", 1, pose=POSE | {"lost": True})
        status, body, headers = recognition("kitchen")
        instance = {"label": "kitchen", "confidence": 0.9, "placement": placement}
        return status, body | {"pose": POSE, "instances": [instance]}, headers

    running = Stub(answer)
    yield running
    running.stop()


def parts(request: Request) -> dict[str, bytes]:
    """The parts of a form by their names."""
    boundary = request.headers["content-type"].partition("boundary=")[2].encode()
    found = {}
    for part in request.body.split(b"--" + boundary)[1:-1]:
        head, _, content = part.partition(b"\r\n\r\n")
        found[head.partition(b'name="')[2].partition(b'"')[0].decode()] = content.removesuffix(b"\r\n")
    return found


def test_an_exemplar_is_taught_with_its_pose(stub: Stub) -> None:
    with Client(stub.url) as client:
        client.teach("home", "kitchen", room(0), pose=MapPose("hall", 1.5, -2, 90, sigma_m=0.1), camera="front")
        client.teach("home", "sign", room(0), camera=CAMERA, size_mm=210)
    raw, form = stub.requests
    assert raw.query == {
        "label": "kitchen", "map": "hall", "x_m": "1.5", "y_m": "-2", "yaw_deg": "90", "sigma_m": "0.1",
        "camera": "front",
    }  # fmt: skip
    assert raw.headers["content-type"] == "image/png"
    assert raw.body.startswith(b"\x89PNG")
    assert form.query == {"label": "sign", "size_mm": "210"}
    sent = parts(form)
    assert sent["image"].startswith(b"\x89PNG")
    assert json.loads(sent["camera"]) == CAMERA.body()


def test_an_answer_has_the_pose_and_that_of_its_landmarks(stub: Stub) -> None:
    with Client(stub.url) as client:
        answer = client.recognise("home", room(0), camera=CAMERA)
    # Sent to this machine, an array needn't be small; what is taught is kept.
    assert parts(stub.requests[0])["image"].startswith(b"P5")
    assert isinstance(answer.pose, PlacePose)
    assert (answer.pose.map, answer.pose.x_m, answer.pose.yaw_deg) == ("hall", 1.5, 90)
    assert (answer.pose.support, answer.pose.lost, len(answer.pose.covariance)) == (("a", "b"), False, 9)
    placement: Any = answer.instances[0].placement
    landmark = LandmarkPose.of(placement)
    assert landmark is not None
    assert landmark.translation_m == (0.1, 0, 2)
    assert landmark.ambiguous
    assert landmark.alternative is not None
    assert (landmark.error_px, landmark.alternative.error_px) == (0.3, 0.4)


def test_frames_of_a_track_are_sent_with_odometry(stub: Stub) -> None:
    with Client(stub.url) as client, client.track("home") as track:
        frame = track.frame(room(0), odometry=Odometry(0.5, -0.25, 3), camera="front")
    assert isinstance(frame.pose, PlacePose)
    assert frame.pose.lost
    query = next(each.query for each in stub.requests if each.path.endswith("/frames"))
    assert query["camera"] == "front"
    assert [query[name] for name in ("dx_m", "dy_m", "dyaw_deg")] == ["0.5", "-0.25", "3"]


def test_cameras_are_kept(stub: Stub) -> None:
    with Client(stub.url) as client:
        client.keep_camera("front", CAMERA)
        assert client.camera("front") == CAMERA
        assert list(client.cameras()) == ["front", "rear"]
        client.forget_camera("front")
    assert [each.method for each in stub.requests] == ["PUT", "GET", "GET", "DELETE"]
    assert json.loads(stub.requests[0].body) == CAMERA.body()
