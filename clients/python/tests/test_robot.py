"""The robot's loop against the real service, there and away."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from drawing import moved, room
from fixtures import ROOMS, teach_rooms
from PIL import Image
from service import BINARY, Service

from landmarkd import Client
from landmarkd.backoff import Backoff
from landmarkd.frames import Frame, Newest, played, watched
from landmarkd.kept_version import KeptVersion
from landmarkd.robot import Robot
from landmarkd.sighting import Sighting
from landmarkd.stand_in import StandIn


def seen_at(label: str, number: int) -> Frame:
    """The nth frame of a robot that stands in a room."""
    return Frame(f"{label}-{number}", moved(room(ROOMS.index(label)), number % 4, 1), f"{number}.5")


def test_frames_of_a_track_add_up(client: Client, home: str) -> None:
    robot = Robot(client, home, motion="still")
    frames = [seen_at("workshop", number) for number in range(3)]
    sightings = list(robot.sightings(frames, every_frame=True))
    assert [each.frame_id for each in sightings] == ["workshop-0", "workshop-1", "workshop-2"]
    assert {each.source for each in sightings} == {"track"}
    assert sightings[-1].decision is not None
    assert sightings[-1].decision.label == "workshop"


def test_single_answers_add_up_too(client: Client, home: str) -> None:
    robot = Robot(client, home, tracked=False)
    sightings: list[Sighting] = []
    robot.run([seen_at("kitchen", number) for number in range(3)], sightings.append, every_frame=True)
    assert {each.source for each in sightings} == {"single"}
    assert sightings[-1].decision is not None
    assert sightings[-1].decision.label == "kitchen"
    assert sightings[-1].belief[0].probability >= sightings[0].belief[0].probability > 0.5


def test_a_damaged_frame_is_passed_over(client: Client, home: str) -> None:
    robot = Robot(client, home)
    frames = [Frame("bad", b"\x89PNG\r\n\x1a\nbroken", "1.0"), seen_at("stairs", 1)]
    assert [each.frame_id for each in robot.sightings(frames, every_frame=True)] == ["stairs-1"]
    assert robot.unanswered == 1


def test_the_newest_frame_wins() -> None:
    go_on = threading.Event()

    def source() -> Iterator[Frame]:
        for number in range(5):
            yield seen_at("kitchen", number)
        go_on.wait(5)
        yield seen_at("kitchen", 9)

    newest = Newest(source())
    time.sleep(0.2)
    first = newest.take()
    assert first is not None
    assert first.id == "kitchen-4"
    assert newest.dropped == 4
    assert newest.take(0.05) is None
    go_on.set()
    last = newest.take(5)
    assert last is not None
    assert last.id == "kitchen-9"
    assert newest.take(5) is None
    assert newest.ended


def test_what_goes_wrong_with_a_camera_is_raised() -> None:
    def source() -> Iterator[Frame]:
        yield seen_at("kitchen", 0)
        raise OSError("unplugged")

    newest = Newest(source())
    time.sleep(0.1)
    assert newest.take() is not None
    with pytest.raises(OSError, match="unplugged"):
        newest.take()


def test_folders_are_played_or_watched(tmp_path: Path) -> None:
    for name in ("b.png", "a.png", "notes.txt"):
        Image.fromarray(room(0)).save(tmp_path / name, "PNG")
    assert [frame.id for frame in played(tmp_path, 0)] == ["a.png", "b.png"]
    stop = threading.Event()
    frames = watched(tmp_path, stop, poll_s=0.01)
    next(frames)
    (tmp_path / "c.tmp").write_bytes(b"picture")
    (tmp_path / "c.tmp").rename(tmp_path / "c.jpg")
    assert next(frames).id == "c.jpg"
    stop.set()
    assert list(frames) == []


def test_a_kept_version_is_fetched_when_it_changed(client: Client, home: str, tmp_path: Path) -> None:
    kept = KeptVersion(tmp_path)
    assert kept.note is None
    assert kept.refresh(client, home)
    assert not kept.refresh(client, home)
    note = kept.note
    assert note is not None
    assert (note.version, note.labels, note.kind) == (1, 3, "landmarks")
    artifact = client.artifact(home)
    assert artifact is not None
    assert kept.artifact(note) == artifact.content
    other = client.train(home, options={"interest_points": 20}, promote="always").version
    try:
        assert kept.refresh(client, home)
        assert kept.note is not None
        assert kept.note.version == other
        assert len(list(tmp_path.glob("*.safetensors"))) == 1
    finally:
        client.point(home, 1)
    (tmp_path / "version.json").write_text('{"version": 1')
    assert kept.note is None
    assert kept.refresh(client, home)


def test_a_local_service_answers_while_the_real_one_is_away(folder: Path, tmp_path: Path) -> None:
    fleet = Service(folder)
    port = fleet.port
    client = Client(fleet.url, timeout_s=5)
    teach_rooms(client, "home")
    kept = KeptVersion(tmp_path / "robot" / "version")
    stand_in = StandIn(Path(BINARY), tmp_path / "robot" / "data")
    robot = Robot(
        client,
        "home",
        motion="still",
        kept=kept,
        stand_in=stand_in,
        patience_s=0,
        refresh_s=0.1,
        backoff=Backoff(0.1, 0.3),
    )
    robot.keep_fresh()

    def see(label: str, number: int) -> Sighting:
        for _ in range(200):
            if (sighting := robot.see(seen_at(label, number))) is not None:
                return sighting
            time.sleep(0.02)
        raise AssertionError("nobody answers")

    try:
        there = [see("stairs", number) for number in range(3)]
        assert {each.source for each in there} == {"track"}
        for _ in range(100):
            if kept.note is not None:
                break
            time.sleep(0.05)
        fleet.kill()
        away = [see("stairs", number) for number in range(3, 6)]
        assert {each.source for each in away} == {"local"}
        # The belief went on: it didn't begin anew.
        assert away[0].decision is not None
        assert away[0].decision.label == "stairs"
        assert away[0].belief[0].probability > 0.9
        assert {each.digest for each in there + away} == {there[0].digest}
        assert stand_in.runs
        local = stand_in.client
        assert local is not None
        assert local.url.startswith("http://127.0.0.1:")

        fleet = Service(folder, port)
        for number in range(6, 200):
            back = see("workshop", number)
            if back.source == "track":
                break
            time.sleep(0.05)
        assert back.source == "track"
        assert not stand_in.runs
        last = see("workshop", 201)
        assert last.decision is not None
        assert last.decision.label == "workshop"

        # Away again: what was taken in once is there.
        fleet.kill()
        assert see("kitchen", 300).source == "local"
        assert stand_in.client is not None
        versions = stand_in.client.database("home").versions
        assert versions == 1
    finally:
        robot.close()
        client.close()
        fleet.stop()
    assert not stand_in.runs


def test_the_program_tells_what_it_sees(service: Service, home: str, tmp_path: Path) -> None:
    for number in range(3):
        Image.fromarray(moved(room(0), number, 0)).save(tmp_path / f"{number}.png")
    command = [sys.executable, "-m", "landmarkd.robot", "--service", service.url, "--database", home]
    command += ["--frames", str(tmp_path)]
    ran = subprocess.run([*command, "--every-frame", "--json"], capture_output=True, text=True, timeout=60, check=False)
    assert (ran.returncode, ran.stderr) == (0, "")
    printed = [json.loads(line) for line in ran.stdout.splitlines()]
    assert [each["frame_id"] for each in printed] == ["0.png", "1.png", "2.png"]
    assert printed[-1]["decision"]["label"] == "kitchen"
    ran = subprocess.run([*command, "--rate-hz", "20"], capture_output=True, text=True, timeout=60, check=False)
    assert "kitchen" in ran.stdout.splitlines()[-1]
    command[command.index(home)] = "nowhere"
    ran = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert ran.returncode == 2
    assert "unknown_database" in ran.stderr


def test_the_program_ends_with_its_local_service(folder: Path, tmp_path: Path) -> None:
    fleet = Service(folder)
    with Client(fleet.url) as client:
        teach_rooms(client, "home")
    frames = tmp_path / "frames"
    frames.mkdir()
    Image.fromarray(room(0)).save(frames / "0.png")
    with Client(fleet.url) as client:
        KeptVersion(tmp_path / "robot" / "version").refresh(client, "home")
    fleet.kill()
    command = [
        sys.executable,
        "-m",
        "landmarkd.robot",
        "--service",
        fleet.url,
        "--database",
        "home",
        "--json",
        "--verbose",
    ]
    command += [
        "--watch",
        str(frames),
        "--keep",
        str(tmp_path / "robot"),
        "--local-binary",
        BINARY,
        "--patience-s",
        "0",
    ]
    robot = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert robot.stdout is not None
        printed = json.loads(robot.stdout.readline())
        assert (printed["source"], printed["frame_decision"]["label"]) == ("local", "kitchen")
        robot.send_signal(signal.SIGTERM)
        _, log = robot.communicate(timeout=20)
    finally:
        robot.kill()
    address = next(word for line in log.splitlines() if "in its place" in line for word in line.split()[:1])
    with Client(address, timeout_s=1) as client, pytest.raises(Exception, match="doesn't answer"):
        client.info()
