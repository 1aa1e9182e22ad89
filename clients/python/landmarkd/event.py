"""Server-sent events, as the service sends them: of a job, and of all that happens."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Event:
    """Something that happened."""

    id: str
    """Counts up; the stream is taken up again after it."""
    kind: str
    """`decision`, `version` or `job`; `message` where a stream has one kind."""
    data: dict[str, Any]
    """What happened."""


def events(lines: Iterable[str]) -> Iterator[Event]:
    """The events of a stream, whose data are objects as JSON. One that broke off in its middle is left out."""
    last, kind = "", "message"
    data: list[str] = []
    for line in lines:
        if not line:
            if data:
                yield Event(last, kind, json.loads("\n".join(data)))
            kind, data = "message", []
        elif not line.startswith(":"):
            name, _, value = line.partition(":")
            value = value.removeprefix(" ")
            if name == "id":
                last = value
            elif name == "event":
                kind = value
            elif name == "data":
                data.append(value)
