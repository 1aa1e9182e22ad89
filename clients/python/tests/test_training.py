"""Teaching, training and what comes of it."""

from __future__ import annotations

from uuid import UUID

import httpx
import numpy as np
import pytest
from drawing import part, room
from service import Service

from landmarkd import Artifact, Client, Job, JobFailed, Problem
from landmarkd._generated.api.databases import list_versions
from landmarkd._generated.models import PageVersionBody
from landmarkd.event import Event, events


def test_training_tells_its_progress(client: Client) -> None:
    client.create("progress", options={"interest_points": 32})
    first = client.teach("progress", "one", room(5), frame_id="a")
    assert client.teach("progress", "one", room(5)).id == first.id
    client.teach("progress", "two", room(6))
    background = client.teach("progress", None, room(7), negative=True)
    assert (background.label, background.negative) == (None, True)
    seen: list[Job] = []
    job = client.train("progress", on_progress=seen.append)
    assert (job.state, job.version) == ("succeeded", 1)
    assert UUID(job.id)
    assert seen[-1] == job
    assert any(each.state == "running" and each.stage and each.done <= each.total for each in seen)
    assert client.database("progress").current_version == 1
    # Followed once more, all its events are sent again.
    again: list[Job] = []
    assert client.follow(job.id, again.append) == job
    assert [each.state for each in again] == [each.state for each in seen]


def test_training_may_be_left_alone(client: Client, home: str) -> None:
    job = client.train(home, options={"interest_points": 24}, promote="never", wait=False)
    assert not job.ended
    version = client.follow(job.id).version
    assert version is not None
    assert version > 1
    assert client.number(home) == 1


def test_a_failed_training_is_an_exception(client: Client) -> None:
    client.create("blank")
    client.teach("blank", "nothing", room(0) * 0)
    with pytest.raises((JobFailed, Problem)) as caught:
        client.train("blank")
    if isinstance(caught.value, JobFailed):
        assert caught.value.job.problem is not None
        assert caught.value.job.problem.code


def test_events_are_read_as_the_standard_has_them() -> None:
    lines = [": hello", "", "id: 1", 'data: {"a":', "data:1}", "", "event: x", "id:2", 'data: {"b": 2}', "", "data: {"]
    assert list(events(lines)) == [Event("1", "message", {"a": 1}), Event("2", "x", {"b": 2})]


def test_an_artifact_is_fetched_once(client: Client, home: str) -> None:
    artifact = client.artifact(home)
    assert isinstance(artifact, Artifact)
    assert (artifact.version, artifact.etag[0], artifact.etag[-1]) == (1, '"', '"')
    assert client.artifact(home, 1, etag=artifact.etag) is None
    client.create("copy")
    taken = client.take_in("copy", artifact.content)
    assert client.take_in("copy", artifact.content).version == taken.version
    client.point("copy", taken.version)
    there, here = client.recognise("copy", room(1)), client.recognise(home, room(1), version=1)
    assert there.votes == here.votes
    assert there.digest == here.digest
    assert client.version("copy").digest == there.digest


def test_calls_without_a_method_are_generated(client: Client, home: str) -> None:
    page = list_versions.sync(home, client=client.generated)
    assert isinstance(page, PageVersionBody)
    assert page.items[0].digest == client.version(home, page.items[0].version).digest


def test_parts_on_a_table_are_found_and_named(client: Client, service: Service) -> None:
    client.create("parts", "objects", {"segment": True})
    for number, label in enumerate(("bar", "block")):
        for turn in range(0, 360, 30):
            client.teach("parts", label, part(number, turn), pose_deg=turn)
    client.train("parts")
    cell = {
        "database": "parts",
        "correspondences": [
            {"image_px": [0, 0], "robot_mm": [0, 100]},
            {"image_px": [200, 0], "robot_mm": [100, 100]},
            {"image_px": [0, 200], "robot_mm": [0, 0]},
        ],
    }
    httpx.put(f"{service.url}/v1/workcells/bench", json=cell).raise_for_status()
    table = np.full((200, 200), 8, np.uint8)
    table[20:84, 20:84] = part(0, 60)
    table[110:174, 120:184] = part(1, 0)
    seen = client.inspect("bench", table, frame_id="t")
    assert seen.header.frame_id == "t"
    assert seen.regions_found == 2
    places = {}
    for found in seen.objects:
        assert found.decision
        assert found.robot_mm
        places[found.decision.label] = found.robot_mm
    assert places["bar"] == pytest.approx([25.75, 74.25], abs=2)
    assert places["block"] == pytest.approx([75.75, 29.25], abs=2)
    answer = client.recognise("parts", part(0, 90))
    assert answer.kind == "objects"
    assert answer.candidates
    assert answer.votes == []
