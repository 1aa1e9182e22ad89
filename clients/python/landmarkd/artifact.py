"""A trained version as one file."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Artifact:
    """A version's file: it recognises, here or at another service."""

    database: str
    version: int
    etag: str
    """Entity tag of the file, with its quotes: another call with it asks whether there is another file."""
    content: bytes
