"""A trained version as one file."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Artifact:
    """A version's file, with which any service recognises."""

    database: str
    version: int
    etag: str
    """Entity tag of the file, with its quotes, for `Client.artifact(etag=…)`."""
    content: bytes
