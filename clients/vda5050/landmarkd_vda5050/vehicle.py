"""A vehicle on MQTT: a connection of its own, because VDA 5050's last will is the vehicle's.

Topics are `{interface}/v2/{manufacturer}/{serial number}/{topic}`. `connection` is retained and of quality 1, the
others are of quality 0, as VDA 5050 has it.
"""

from __future__ import annotations

import json
import logging
import threading
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime, timezone
from typing import Any
from urllib.parse import urlsplit

from paho.mqtt.client import Client, MQTTMessageInfo
from paho.mqtt.enums import CallbackAPIVersion

from landmarkd.planar import Planar

from . import state
from .state import Known

log = logging.getLogger("landmarkd.vda5050")

HEARTBEAT_S = 30.0
"""VDA 5050 wants a state at least so often."""


@dataclass(frozen=True)
class Broker:
    """Where messages go."""

    url: str
    """`mqtt://host:1883`, or `mqtts://host:8883` for TLS."""
    user: str = ""
    password: str = ""
    interface: str = "uagv"
    manufacturer: str = "landmarkd"


class Vehicle:
    """Publishes what is known of one robot, when it changes and every half minute.

    Args:
        broker: where to.
        serial_number: of the vehicle.
        mounted: `T_base_camera`, where its camera sits and looks.
        whole: publishes `state`; otherwise `visualization`, beside the state of the vehicle's own controller.
        stale_s: a position older than this isn't one any more.
        now_s: the clock, in seconds.

    """

    def __init__(
        self,
        broker: Broker,
        serial_number: str,
        mounted: Planar,
        *,
        whole: bool = True,
        stale_s: float = 10.0,
        now_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self.broker = broker
        self.serial_number = serial_number
        self.mounted = mounted
        self.whole = whole
        self.stale_s = stale_s
        self._now_s = now_s
        self._known: Known | None = None
        self._known_s = 0.0
        self._was_fresh = False
        self._sent_s = float("-inf")
        self._counts: Counter[str] = Counter()
        self._lock = threading.Lock()
        address = urlsplit(broker.url)
        if address.scheme not in ("mqtt", "mqtts") or not address.hostname:
            raise ValueError(f"{broker.url} is no broker: mqtt://host:1883 or mqtts://host:8883")
        self._client = Client(CallbackAPIVersion.VERSION2, client_id=f"landmarkd-{serial_number}")
        if broker.user:
            self._client.username_pw_set(broker.user, broker.password)
        if address.scheme == "mqtts":
            self._client.tls_set()
        if whole:
            # The vehicle's own controller has it otherwise.
            will = self._message("connection", state.connection("CONNECTIONBROKEN"))
            self._client.will_set(self._topic("connection"), will, qos=1, retain=True)
        self._client.on_connect = self._connected
        self._client.connect_async(address.hostname, address.port or (8883 if address.scheme == "mqtts" else 1883))
        # It connects again by itself.
        self._client.loop_start()

    def _topic(self, name: str) -> str:
        return f"{self.broker.interface}/v2/{self.broker.manufacturer}/{self.serial_number}/{name}"

    def _message(self, name: str, body: dict[str, Any]) -> str:
        """A message with the next header of its topic."""
        with self._lock:
            number = self._counts[name]
            self._counts[name] += 1
        now = datetime.now(timezone.utc)
        return json.dumps(state.headed(number, self.broker.manufacturer, self.serial_number, now, body))

    def _connected(self, client: Any, userdata: Any, flags: Any, reason: Any, properties: Any) -> None:
        """Say so, also after the will was carried out."""
        if reason.is_failure:
            log.warning("%s refuses vehicle %s: %s", self.broker.url, self.serial_number, reason)
        if self.whole:
            self._say("connection", state.connection("ONLINE"))
        # What was learnt while nobody could be told.
        self._publish()

    def _say(self, name: str, body: dict[str, Any]) -> MQTTMessageInfo:
        """Publish on a topic, in the quality that it has."""
        kept = name == "connection"
        return self._client.publish(self._topic(name), self._message(name, body), qos=1 if kept else 0, retain=kept)

    def learn(self, known: Known) -> None:
        """Take a decision in, and publish it."""
        self._known, self._known_s = known, self._now_s()
        self._publish()

    def tick(self) -> None:
        """Publish what is due: the position became stale, or nothing was said for long."""
        if self._was_fresh != self._fresh or self._now_s() - self._sent_s >= HEARTBEAT_S:
            self._publish()

    @property
    def _fresh(self) -> bool:
        return self._now_s() - self._known_s <= self.stale_s

    def _publish(self) -> None:
        """Publish what is known, if anything is and the broker is there."""
        if self._known is None or not self._client.is_connected():
            return
        fresh = self._fresh
        self._was_fresh, self._sent_s = fresh, self._now_s()
        name, make = ("state", state.state) if self.whole else ("visualization", state.visualization)
        body = make(self._known, self.mounted, fresh)
        if body:
            self._say(name, body)

    def close(self) -> None:
        """Say that it goes, and go."""
        if self.whole:
            sent = self._say("connection", state.connection("OFFLINE"))
            if self._client.is_connected():
                sent.wait_for_publish(5)
        self._client.disconnect()
        self._client.loop_stop()
