"""A little server that answers what a test says, in that order, and notes when it was asked."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

Answer = tuple[int, dict[str, Any], dict[str, str]]
"""Status, body, headers."""


class Stub:
    """Answers each request by `answer(method, path)`."""

    def __init__(self, answer: Callable[[str, str], Answer]) -> None:
        asked = self.asked = list[tuple[float, str, str]]()

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def answer(self) -> None:
                self.rfile.read(int(self.headers.get("Content-Length", 0)))
                asked.append((time.monotonic(), self.command, self.path.partition("?")[0]))
                status, body, headers = answer(self.command, self.path.partition("?")[0])
                content = json.dumps(body).encode()
                self.send_response(status)
                for name, value in headers.items():
                    self.send_header(name, value)
                self.send_header("Content-Type", "application/json" if status < 400 else "application/problem+json")
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


def refusal(status: int, code: str, retry_after: str | None = None) -> Answer:
    """A problem document."""
    body = {"type": f"/problems/{code}", "title": code, "status": status, "detail": "later", "code": code}
    return status, body, {} if retry_after is None else {"Retry-After": retry_after}


def recognition(label: str | None) -> Answer:
    """An answer of a database of landmarks."""
    return 200, {
        "database": "home", "kind": "landmarks", "version": 1, "digest": "d", "header": {}, "warnings": [],
        "decision": {"label": label, "confidence": 0.9} if label else None,
        "timings_ms": dict.fromkeys(
            ("queue", "decode", "recognise", "attention", "signature", "search", "vote", "verification"), 0.0
        ),
        "votes": [], "instances": [], "points_used": 0, "points_found": 0,
    }, {}  # fmt: skip


def version() -> Answer:
    """Version 1, of three labels."""
    return 200, {
        "version": 1, "digest": "d", "created_at": "2026-01-01T00:00:00Z", "revision": 1, "artifact_bytes": 1,
        "options": {}, "counts": {"exemplars": 3, "labels": 3, "interest_points": 3},
        "report": {"spectrum": [], "energy_kept": 1.0, "dimension": 1, "signature_length": 1, "colour": "gray",
                   "exemplars_without_points": [], "warnings": []},
    }, {}  # fmt: skip
