"""A little server that answers what a test says, in that order, and notes when it was asked."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import parse_qsl

Document = tuple[int, dict[str, Any], dict[str, str]]
"""Status, body, headers."""
Answer = Document | tuple[int, str, dict[str, str]]
"""The same, or with the text of a stream of events."""


@dataclass(frozen=True)
class Request:
    """What was sent."""

    method: str
    path: str
    query: dict[str, str]
    headers: dict[str, str]
    """By their names in small letters."""
    body: bytes


class Stub:
    """Answers each request by `answer(method, path)`."""

    def __init__(self, answer: Callable[[str, str], Answer]) -> None:
        asked = self.asked = list[tuple[float, str, str]]()
        requests = self.requests = list[Request]()

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def answer(self) -> None:
                sent = self.rfile.read(int(self.headers.get("Content-Length", 0)))
                path, _, query = self.path.partition("?")
                heads = {name.lower(): value for name, value in self.headers.items()}
                asked.append((time.monotonic(), self.command, path))
                requests.append(Request(self.command, path, dict(parse_qsl(query)), heads, sent))
                status, body, headers = answer(self.command, path)
                stream = isinstance(body, str)
                content = b"" if status == 204 else (body if isinstance(body, str) else json.dumps(body)).encode()
                self.send_response(status)
                for name, value in headers.items():
                    self.send_header(name, value)
                usual = "application/json" if status < 400 else "application/problem+json"
                self.send_header("Content-Type", "text/event-stream" if stream else usual)
                self.send_header("Content-Length", str(len(content)))
                self.end_headers()
                self.wfile.write(content)

            do_GET = do_POST = do_PUT = do_DELETE = answer  # noqa: N815

            def log_message(self, *words: object) -> None:
                pass

        self.server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.server.daemon_threads = True
        self.url = f"http://127.0.0.1:{self.server.server_port}"
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def stop(self) -> None:
        """End it."""
        self.server.shutdown()
        self.server.server_close()


def refusal(status: int, code: str, retry_after: str | None = None) -> Document:
    """A problem document."""
    body = {"type": f"/problems/{code}", "title": code, "status": status, "detail": "later", "code": code}
    return status, body, {} if retry_after is None else {"Retry-After": retry_after}


def recognition(label: str | None) -> Document:
    """An answer of a database of landmarks."""
    return 200, {
        "database": "home", "kind": "landmarks", "version": 1, "digest": "d", "header": {}, "warnings": [],
        "decision": {"label": label, "confidence": 0.9} if label else None,
        "timings_ms": dict.fromkeys(
            ("queue", "decode", "recognise", "attention", "signature", "search", "vote", "verification"), 0.0
        ),
        "votes": [], "instances": [], "points_used": 0, "points_found": 0,
    }, {}  # fmt: skip


def tracked(label: str, number: int, **more: Any) -> Document:
    """An answer of a track of landmarks."""
    status, body, headers = recognition(label)
    of_track = {
        "track": TRACK,
        "frame": {"number": number, "counted": True, "decision": body["decision"]},
        "belief": [{"label": label, "probability": 0.9, "exemplar": "e"}],
        "elsewhere": 0.1,
        "motion": "still",
        "expires_at": "2026-01-01T00:00:00Z",
    }
    return status, body | of_track | more, headers


TRACK = "00000000-0000-0000-0000-000000000001"


def began() -> Document:
    """A track that was begun."""
    begun = {"id": TRACK, "database": "home", "alias": "current", "version": 1, "motion": "still", "frames": 0}
    now = "2026-01-01T00:00:00Z"
    return 201, begun | {"warnings": [], "created_at": now, "expires_at": now}, {}


def version() -> Document:
    """Version 1, of three labels."""
    return 200, {
        "version": 1, "digest": "d", "created_at": "2026-01-01T00:00:00Z", "revision": 1, "artifact_bytes": 1,
        "options": {}, "counts": {"exemplars": 3, "labels": 3, "interest_points": 3},
        "report": {"spectrum": [], "energy_kept": 1.0, "dimension": 1, "signature_length": 1, "colour": "gray",
                   "exemplars_without_points": [], "warnings": []},
    }, {}  # fmt: skip
