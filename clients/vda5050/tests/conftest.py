"""The tests take the stub of the Python client's tests; the broker is one in Python."""

from __future__ import annotations

import asyncio
import json
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from amqtt.broker import Broker
from paho.mqtt.client import Client
from paho.mqtt.enums import CallbackAPIVersion

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python" / "tests"))


@pytest.fixture(scope="session")
def broker() -> Iterator[str]:
    """A broker on a port of its own; its address."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    config = {
        "listeners": {"default": {"type": "tcp", "bind": f"127.0.0.1:{port}"}},
        "plugins": {"amqtt.plugins.authentication.AnonymousAuthPlugin": {"allow_anonymous": True}},
    }
    loop = asyncio.new_event_loop()
    threading.Thread(target=loop.run_forever, daemon=True).start()

    async def begin() -> Broker:
        begun = Broker(config)
        await begun.start()
        return begun

    running = asyncio.run_coroutine_threadsafe(begin(), loop).result(20)
    yield f"mqtt://127.0.0.1:{port}"
    asyncio.run_coroutine_threadsafe(running.shutdown(), loop).result(20)
    loop.call_soon_threadsafe(loop.stop)


class Listener:
    """Master control: hears all messages of all vehicles."""

    def __init__(self, port: int) -> None:
        self.heard: list[tuple[str, dict[str, Any], bool]] = []
        """Topics, messages, and whether they were retained."""
        ready = threading.Event()
        self.client = Client(CallbackAPIVersion.VERSION2)
        self.client.on_connect = lambda client, *_: client.subscribe("#", qos=1)
        self.client.on_subscribe = lambda *_: ready.set()
        self.client.on_message = lambda client, userdata, message: self.heard.append(
            (message.topic, json.loads(message.payload), bool(message.retain))
        )
        self.client.connect("127.0.0.1", port)
        self.client.loop_start()
        assert ready.wait(10)

    def of(self, topic: str) -> list[dict[str, Any]]:
        """The messages of a topic so far."""
        return [message for at, message, _ in list(self.heard) if at == topic]


@pytest.fixture
def listener(broker: str) -> Iterator[Listener]:
    """Somebody who listens."""
    made = Listener(int(broker.rpartition(":")[2]))
    yield made
    made.client.disconnect()
    made.client.loop_stop()


def waited(true: Callable[[], object], seconds: float = 10) -> None:
    """Wait until something is so."""
    ends = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < ends
        time.sleep(0.01)
