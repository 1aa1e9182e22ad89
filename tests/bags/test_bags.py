"""Bags that others wrote are taught and asked about; the bags of answers are read back by others.

Needs the program (LANDMARKD_BINARY), `rosbags`, `mcap` and `mcap-ros2-support`; clients/test.sh runs it.
"""

import json
import re
import subprocess
import time
import urllib.error
import urllib.request

import pytest
import world
from mcap_ros2.reader import read_ros2_messages
from rosbags.highlevel import AnyReader
from service import BINARY, Service, environment, make_key

LENGTH_M = 8


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("bags")


@pytest.fixture(scope="module")
def taught_bag(folder):
    """Two seconds of waiting, and three blurred pictures."""
    path = folder / "teach"
    world.write_with_rosbags(path, world.drive(LENGTH_M, wait=10, blurred={21, 22, 40}))
    return path


@pytest.fixture(scope="module")
def asked_bag(folder):
    path = folder / "ask"
    world.write_with_rosbags(path, world.drive(LENGTH_M, shift_m=0.07))
    return path


@pytest.fixture(scope="module")
def service(folder):
    running = Service(folder / "data")
    yield running
    running.stop()


def run(*words, key=None, fails=False):
    """What a verb prints; on standard error too if it must fail."""
    given = environment() | ({"LANDMARKD_KEY": key} if key else {})
    command = [BINARY, *(str(word) for word in words)]
    ended = subprocess.run(command, env=given, capture_output=True, text=True, timeout=600)
    assert (ended.returncode != 0) == fails, ended.stdout + ended.stderr
    return ended.stderr if fails else ended.stdout


@pytest.fixture(scope="module")
def taught(taught_bag, service):
    return run("teach", taught_bag, "--database", "hall", "--server", service.url, "--pose-topic", "/odom")


def requests_status(url):
    try:
        with urllib.request.urlopen(url, timeout=10) as answer:
            return answer.status
    except urllib.error.HTTPError as refused:
        return refused.code


def count(pattern, text):
    found = re.search(pattern, text)
    assert found, text
    return int(found[1])


def test_what_is_not_worth_teaching_is_left_out_and_counted(taught):
    # a picture each 0.2 m; one each 0.6 m is taught, and the first of those that show a waiting robot
    assert "50 pictures on /camera/image_raw/compressed" in taught
    assert 12 <= count(r"(\d+) pictures taught", taught) <= 15
    assert 1 <= count(r"(\d+) blurred", taught) <= 3
    assert count(r"(\d+) without a pose", taught) == 0
    assert "by way of /tf" in taught
    assert "fx 300.0" in taught
    assert "version 1" in taught


def test_the_same_bag_again_sends_nothing_new(taught, taught_bag, service):
    again = run("teach", taught_bag, "--database", "hall", "--server", service.url, "--pose-topic", "/odom")
    assert "hall: 0 pictures sent" in again
    assert "version 1" in again


def test_answers_are_held_against_the_bag_and_written_for_others(taught, asked_bag, service, folder):
    out = folder / "answers.mcap"
    told = run(
        "ask", asked_bag, "--database", "hall", "--server", service.url, "--pose-topic", "/odom", "--out", out, "--draw"
    )
    asked = count(r"asked +(\d+)", told)
    assert asked == 39
    answered = count(r"answered +[\d.]+ \((\d+) of", told)
    assert answered >= 0.9 * asked, told
    assert count(r"or beside it +[\d.]+ \((\d+) of", told) >= 0.95 * answered, told

    by_topic = {}
    for message in read_ros2_messages(out):
        by_topic.setdefault(message.channel.topic, []).append(message.ros_msg)
    for topic in ("image/compressed", "drawn/compressed", "outlines", "detections", "decision", "true_pose"):
        assert len(by_topic[f"/landmarkd/{topic}"]) == asked, topic
    detection = by_topic["/landmarkd/detections"][20].detections[0]
    assert detection.results[0].hypothesis.class_id.startswith("hall_")
    outline = by_topic["/landmarkd/outlines"][20].points[0]
    assert outline.type == 2
    assert len(outline.points) == 4
    decisions = {message.data for message in by_topic["/landmarkd/decision"]}
    assert {f"hall_{column}_0" for column in range(1, 3)} <= decisions
    true_pose = by_topic["/landmarkd/true_pose"][10]
    # the camera stands 0.1 m ahead of the base, and looks to the left
    assert abs(true_pose.pose.position.x - 2.17) < 0.02
    assert abs(true_pose.pose.orientation.z - 0.5**0.5) < 1e-6

    with AnyReader([out]) as reader:
        counted = {connection.topic: connection.msgcount for connection in reader.connections}
        assert counted["/landmarkd/detections"] == asked
        for connection, _, raw in reader.messages():
            assert reader.deserialize(raw, connection.msgtype)


@pytest.mark.parametrize("encoding", ["bgr8", "mono8", "bayer_rggb8"])
def test_raw_pictures_of_each_encoding_are_taught_with_poses_out_of_order(encoding, service, folder):
    path = folder / f"{encoding}.mcap"
    world.write_with_mcap(path, world.drive(6), encoding=encoding, shuffle_poses=True)
    database = encoding.replace("_", "-")
    told = run(
        "teach", path, "--database", database, "--server", service.url,
        "--pose-topic", "/amcl_pose", "--camera-mount", "0,0,0.5,90,0,0",
    )  # fmt: skip
    assert count(r"(\d+) poses came after one of a later stamp", told) > 5
    assert 9 <= count(r"(\d+) pictures taught", told) <= 11
    assert "no topic has its intrinsics" in told


def test_bags_are_evaluated_without_a_service(taught_bag, asked_bag):
    figures = json.loads(run("evaluate", taught_bag, asked_bag, "--pose-topic", "/odom", "--json"))
    assert figures["asked"] == 39
    assert figures["answered"] >= 34
    assert figures["near"]["rate"] >= 0.95


def test_a_cut_bag_teaches_what_it_holds(taught_bag, service, folder):
    whole = next(taught_bag.glob("*.mcap")).read_bytes()
    cut = folder / "cut.mcap"
    cut.write_bytes(whole[: len(whole) * 7 // 10])
    # in this bag the pictures come before the poses, so the poses are what is lost
    told = run("teach", cut, "--database", "cut", "--label", "hall", "--server", service.url)
    assert "mcap recover" in told
    assert count(r"(\d+) pictures taught", told) >= 5


def test_refusals_say_what_to_do(taught_bag, service, folder):
    def refused(*words, bag=taught_bag):
        return run("teach", bag, "--database", "other", "--server", service.url, *words, fails=True)

    assert "/odom (nav_msgs/Odometry" in refused("--pose-topic", "/amcl_pose")
    assert "isn't read here" in refused("--pose-topic", "/camera/camera_info")
    assert "--image-topic" in refused("--image-topic", "/camera/other")
    assert "is not a name" in refused("--label", "the hall")
    old = folder / "old.bag"
    old.write_bytes(b"#ROSBAG V2.0\n")
    assert "rosbags-convert" in refused(bag=old)
    assert "can't read" in refused(bag=folder / "absent.mcap")
    no_pose = folder / "no_pose.mcap"
    world.write_with_mcap(no_pose, world.drive(1), encoding="mono8")
    assert "--label" in refused(bag=no_pose)


def test_a_key_that_may_train_is_enough(taught_bag, tmp_path):
    running = Service(tmp_path / "data")
    try:
        admin, reader = (make_key(running.folder, scope) for scope in ("admin", "recognise"))
        # A key made beside a running service is noticed a moment later; until then nobody is asked for one.
        deadline = time.monotonic() + 60
        while requests_status(f"{running.url}/v1/info") != 401:
            assert time.monotonic() < deadline
            time.sleep(0.05)
        words = ("teach", taught_bag, "--database", "keyed", "--server", running.url, "--label", "hall")
        assert "status 403" in run(*words, key=reader, fails=True)
        assert "version 1" in run(*words, key=admin)
    finally:
        running.stop()
