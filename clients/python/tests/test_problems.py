"""What goes wrong, as exceptions."""

from __future__ import annotations

import datetime
import email.utils
from pathlib import Path

import httpx
import pytest
from drawing import room
from service import Service, make_key

from landmarkd import Client, Problem, Unreachable
from landmarkd._generated.api.databases import get_database
from landmarkd.problem import seconds


def test_a_refusal_is_a_problem(client: Client) -> None:
    with pytest.raises(Problem) as caught:
        client.recognise("nowhere", room(0))
    problem = caught.value
    assert (problem.status, problem.code) == (404, "unknown_database")
    assert problem.title
    assert problem.request_id
    assert "nowhere" in problem.detail
    assert problem.retry_after is None
    assert "404 unknown_database" in str(problem)


def test_faults_are_named_by_field(client: Client, home: str) -> None:
    with pytest.raises(Problem) as caught:
        client.create("faulty", options={"rings": -3, "colours": 7})
    assert (caught.value.status, caught.value.code) == (422, "invalid_field")
    assert any("colours" in fault.pointer + fault.detail for fault in caught.value.errors)
    with pytest.raises(Problem) as caught:
        client.recognise(home, room(0), top=0)
    assert [fault.pointer for fault in caught.value.errors] == ["#top"]


@pytest.mark.parametrize(
    ("picture", "code"),
    [
        (b"", "empty_image"),
        (b"no picture at all", "unsupported_image_format"),
        (b"\x89PNG\r\n\x1a\nbroken", "corrupt_image"),
    ],
)
def test_bad_pictures_have_codes_of_their_own(client: Client, home: str, picture: bytes, code: str) -> None:
    with pytest.raises(Problem) as caught:
        client.recognise(home, picture)
    assert caught.value.code == code


def test_generated_calls_raise_the_same(client: Client) -> None:
    with pytest.raises(Problem) as caught:
        get_database.sync("nowhere", client=client.generated)
    assert caught.value.code == "unknown_database"


def test_nobody_there_is_unreachable() -> None:
    with Client("http://127.0.0.1:9", timeout_s=2) as client, pytest.raises(Unreachable, match="doesn't answer"):
        client.info()


def test_keys_come_from_the_call_or_the_environment(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    admin, recognise = make_key(folder, "admin"), make_key(folder, "recognise")
    service = Service(folder)
    try:
        with Client(service.url) as nobody, pytest.raises(Problem) as caught:
            nobody.info()
        assert (caught.value.status, caught.value.code) == (401, "key_required")
        with Client(service.url, admin) as client:
            client.create("lab")
        monkeypatch.setenv("LANDMARKD_KEY", recognise)
        with Client(service.url) as client:
            assert client.database("lab").name == "lab"
            with pytest.raises(Problem) as caught:
                client.teach("lab", "one", room(0))
            assert (caught.value.status, caught.value.code) == (403, "not_allowed")
    finally:
        service.stop()


def test_an_answer_that_is_not_the_services_is_a_problem_too() -> None:
    page = httpx.Response(502, text="<h1>Bad gateway</h1>", headers={"X-Request-Id": "7"})
    problem = Problem.of(page)
    assert (problem.status, problem.code, problem.title, problem.request_id) == (502, "", "Bad Gateway", "7")


def test_retry_after_is_seconds_or_a_date() -> None:
    assert seconds(None) is None
    assert seconds("7") == 7
    assert seconds("soon") is None
    then = datetime.datetime.now(datetime.timezone.utc) + datetime.timedelta(seconds=30)
    wait_s = seconds(email.utils.format_datetime(then, usegmt=True))
    assert wait_s is not None
    assert 28 <= wait_s <= 30
    assert seconds("Wed, 21 Oct 2015 07:28:00 GMT") == 0
