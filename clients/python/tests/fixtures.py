"""One service for all tests that don't need one of their own."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from drawing import moved, room
from service import BINARY, Service

from landmarkd import Client

ROOMS = ("kitchen", "stairs", "workshop")


def pytest_configure() -> None:
    """Fail without the binary: a run that tests nothing must not look like success."""
    if not BINARY or not os.access(BINARY, os.X_OK):
        raise pytest.UsageError("LANDMARKD_BINARY must name the service's program")


@pytest.fixture(autouse=True)
def _no_key_from_outside(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("LANDMARKD_KEY", raising=False)


@pytest.fixture(scope="session")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service without keys."""
    running = Service(tmp_path_factory.mktemp("service"))
    yield running
    running.stop()


@pytest.fixture(scope="session")
def client(service: Service) -> Iterator[Client]:
    """A client of it."""
    with Client(service.url) as client:
        yield client


def teach_rooms(client: Client, database: str) -> None:
    """A database of three rooms, trained."""
    client.create(database)
    for number, label in enumerate(ROOMS):
        for step in range(2):
            client.teach(database, label, moved(room(number), 3 * step, 2 * step))
    client.train(database)


@pytest.fixture(scope="session")
def home(client: Client) -> str:
    """A trained database of rooms."""
    teach_rooms(client, "home")
    return "home"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder for a service of its own."""
    return tmp_path / "data"
