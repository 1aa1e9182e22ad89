"""Answers as messages."""

from __future__ import annotations

import dataclasses
import math

import pytest
import ros

from landmarkd import Decision, LabelBelief, Recognition
from landmarkd._generated.models import InstanceBody, PlacementBody
from landmarkd.sighting import Sighting
from landmarkd_ros import messages


def answer(**more: object) -> Recognition:
    return Recognition("home", "landmarks", 1, "d", Decision("kitchen", 0.9), [], {}, **more)


def placed(label: str) -> InstanceBody:
    # 40 by 20 pixels about (100, 50), turned by 90°.
    corners = [[110.0, 30.0], [110.0, 70.0], [90.0, 70.0], [90.0, 30.0]]
    return InstanceBody(label, 0.75, PlacementBody(100.0, 50.0, 90.0, 1.0, 12, 0.5, corners, "e"))


def test_the_classes_have_the_fields_of_the_messages() -> None:
    for name in messages.NAMES:
        ours = {field.name for field in dataclasses.fields(getattr(messages, name))}
        assert ours <= set(ros.VISION[name].__slots__), name


def test_placements_become_boxes() -> None:
    header = ros.Header()
    header.frame_id = "camera"
    converted = messages.message(
        messages.detections(answer(instances=[placed("kitchen")]), header, 320, 240), ros.VISION
    )
    assert isinstance(converted, ros.Detection2DArray)
    assert converted.header is header
    (detection,) = converted.detections
    assert isinstance(detection, ros.Detection2D)
    assert detection.header is header
    (result,) = detection.results
    assert (result.hypothesis.class_id, result.hypothesis.score) == ("kitchen", 0.75)
    box = detection.bbox
    assert (box.center.position.x, box.center.position.y) == (100, 50)
    assert box.center.theta == pytest.approx(math.pi / 2)
    assert (box.size_x, box.size_y) == (40, 20)


def test_an_object_is_the_whole_frame() -> None:
    seen = dataclasses.replace(answer(), kind="objects", decision=Decision("cup", None))
    (detection,) = messages.detections(seen, None, 64, 32).detections
    assert (detection.bbox.size_x, detection.bbox.size_y, detection.bbox.center.position.x) == (64, 32, 31.5)
    assert math.isnan(detection.results[0].hypothesis.score)
    assert messages.detections(dataclasses.replace(seen, decision=None), None, 64, 32).detections == []


def test_decisions_and_beliefs_become_classifications() -> None:
    assert messages.classification(None, None).results == []
    converted = messages.message(messages.classification(Decision("kitchen", 0.9), None), ros.VISION)
    assert [(each.class_id, each.score) for each in converted.results] == [("kitchen", 0.9)]
    believed = [LabelBelief("kitchen", 0.7), LabelBelief("stairs", 0.2)]
    sighting = Sighting("1", "1.0", "track", 1, "d", None, believed, 0.1, None, [], 5.0, answer())
    assert [(each.class_id, each.score) for each in messages.belief(sighting, None).results] == [
        ("kitchen", 0.7),
        ("stairs", 0.2),
    ]


def test_a_message_without_the_field_is_found_out() -> None:
    other = ros.message_type("Classification", header=ros.Header)
    with pytest.raises(AttributeError):
        messages.message(messages.Classification(None, []), {"Classification": other})
