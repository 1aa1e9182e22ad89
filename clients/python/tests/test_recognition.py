"""Recognition by the front, against the real service."""

from __future__ import annotations

import io
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from drawing import moved, room
from fixtures import ROOMS
from PIL import Image
from service import Service

import landmarkd.picture
from landmarkd import Client, Picture, Recognition


def test_five_lines_recognise(service: Service, home: str, tmp_path: Path) -> None:
    Image.fromarray(room(1)).save(tmp_path / "frame.png")
    program = f"""from landmarkd import Client

client = Client("{service.url}")
answer = client.recognise("{home}", "frame.png")
print(answer.decision.label if answer.decision else "nothing known")"""
    assert len(program.splitlines()) == 5
    ran = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (ran.stdout, ran.stderr) == ("stairs\n", "")


def test_an_answer_is_typed(client: Client, home: str) -> None:
    answer = client.recognise(home, room(0), frame_id="7", stamp="12.5", explain=True)
    assert isinstance(answer, Recognition)
    assert answer.decision is not None
    assert answer.decision.label == "kitchen"
    assert answer.decision.confidence is None or 0.8 <= answer.decision.confidence <= 1
    assert (answer.kind, answer.version, answer.frame_id, answer.stamp) == ("landmarks", 1, "7", "12.5")
    assert answer.votes[0].label == "kitchen"
    assert answer.points
    assert all(0 <= point.x_px < 160 and 0 <= point.y_px < 160 for point in answer.points)
    assert sum(point.weight for point in answer.points if point.label == "kitchen") == pytest.approx(
        answer.votes[0].weight
    )
    assert {"queue", "decode", "recognise", "vote"} <= answer.timings_ms.keys()
    assert answer.candidates == []
    assert answer.pose is None


def test_nothing_known_is_an_answer(client: Client, home: str) -> None:
    assert client.recognise(home, np.full((160, 160), 128, np.uint8)).decision is None


def test_a_picture_may_come_in_any_form(
    client: Client, home: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "frame.png"
    Image.fromarray(room(2)).save(path)
    coloured = np.repeat(room(2)[:, :, None], 3, axis=2)
    deep = room(2).astype(np.uint16) * 257
    forms: list[Picture] = [path, str(path), path.read_bytes(), io.BytesIO(path.read_bytes()), room(2), coloured, deep]
    votes = [client.recognise(home, form).votes[0].weight for form in forms]
    monkeypatch.setattr(landmarkd.picture, "Image", None)
    votes += [client.recognise(home, array).votes[0].weight for array in (room(2), coloured, deep)]
    assert votes == pytest.approx([votes[0]] * len(votes), rel=0.1)


@pytest.mark.parametrize("array", [np.zeros((4, 4)), np.zeros((4, 4, 4), np.uint8), np.zeros(4, np.uint8)])
def test_an_array_that_is_no_picture_is_refused(client: Client, home: str, array: np.ndarray) -> None:
    with pytest.raises(ValueError, match="a picture is an array"):
        client.recognise(home, array)


def test_frames_of_a_track_add_up(client: Client, home: str) -> None:
    with client.track(home, motion="still") as track:
        first = track.frame(moved(room(1), 1, 0), frame_id="1")
        again = track.frame(moved(room(1), 1, 0), frame_id="1")
        second = track.frame(moved(room(1), 2, 1), frame_id="2")
    assert [first.number, again.number, second.number] == [1, 1, 2]
    assert [first.counted, again.counted, second.counted] == [True, False, True]
    assert second.belief[0].label == "stairs"
    assert second.belief[0].probability > 0.5
    assert second.decision is not None
    assert sum(each.probability for each in second.belief) + second.elsewhere == pytest.approx(1)
    assert len(second.belief) == len(ROOMS)
    with pytest.raises(landmarkd.Problem) as caught:
        track.frame(room(1))
    assert caught.value.code == "unknown_track"
