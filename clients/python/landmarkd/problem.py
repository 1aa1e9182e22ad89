"""What can go wrong: the service's problem documents (RFC 9457) as exceptions, and a service that isn't there."""

from __future__ import annotations

import datetime
import email.utils
from dataclasses import dataclass
from typing import Any

import httpx


@dataclass(frozen=True)
class FieldFault:
    """A field at fault: where it stands (a JSON pointer, or `#name` for a parameter) and what is wrong with it."""

    pointer: str
    detail: str


class Problem(Exception):
    """The service refused a call. `code` is for programs, `detail` says what to do."""

    status: int
    """HTTP status."""
    code: str
    """Kind of problem, such as `not_trained`; empty if the answer wasn't the service's own, as a proxy's may be."""
    title: str
    """One line on the kind of problem."""
    detail: str
    """What happened, and what to do."""
    errors: list[FieldFault]
    """The fields at fault."""
    retry_after: float | None
    """Seconds until it is worth asking again, with 429 and 503."""
    request_id: str | None
    """Id of the request, as the service's log has it."""

    def __init__(
        self,
        status: int,
        code: str = "",
        *,
        title: str = "",
        detail: str = "",
        errors: list[FieldFault] | None = None,
        retry_after: float | None = None,
        request_id: str | None = None,
    ) -> None:
        super().__init__(f"{status} {code or title}: {detail}" if detail else f"{status} {code or title}")
        self.status = status
        self.code = code
        self.title = title
        self.detail = detail
        self.errors = errors or []
        self.retry_after = retry_after
        self.request_id = request_id

    @classmethod
    def of(cls, response: httpx.Response) -> Problem:
        """The problem of an answer with an error's status; its body must have been read."""
        body = document(response)
        return cls(
            response.status_code,
            str(body.get("code", "")),
            title=str(body.get("title", response.reason_phrase)),
            detail=str(body.get("detail", "")),
            errors=[
                FieldFault(str(fault.get("pointer", "")), str(fault.get("detail", "")))
                for fault in body.get("errors") or []
                if isinstance(fault, dict)
            ],
            retry_after=seconds(response.headers.get("Retry-After")),
            request_id=body.get("request_id") or response.headers.get("X-Request-Id"),
        )


class Unreachable(Exception):
    """No answer came: the service is away, or the network between."""


def document(response: httpx.Response) -> dict[str, Any]:
    """The body as an object; an empty one for anything that is none."""
    try:
        body = response.json()
    except ValueError:
        return {}
    return body if isinstance(body, dict) else {}


def seconds(retry_after: str | None) -> float | None:
    """`Retry-After` in seconds from now: it is a number of them, or a date."""
    if retry_after is None:
        return None
    try:
        return max(0.0, float(int(retry_after)))
    except ValueError:
        pass
    try:
        then = email.utils.parsedate_to_datetime(retry_after)
    except ValueError:
        return None
    if then.tzinfo is None:
        then = then.replace(tzinfo=datetime.timezone.utc)
    return max(0.0, (then - datetime.datetime.now(datetime.timezone.utc)).total_seconds())
