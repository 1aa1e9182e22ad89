"""The version in use as a file on the robot, for when the service is away."""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass
from pathlib import Path

from .belief import Rates
from .client import Client

NOTE = "version.json"


@dataclass(frozen=True)
class Note:
    """What is kept: the version, its database and service, and its observation model."""

    service: str
    database: str
    kind: str
    version: int
    digest: str
    etag: str
    labels: int
    rates: Rates
    file: str
    """Name of the artifact's file, beside this note."""


class KeptVersion:
    """A folder with an artifact and a note on it.

    The note is written last and atomically, so that the file it names is complete.

    Args:
        folder: made if missing; one for each database.

    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True)

    @property
    def note(self) -> Note | None:
        """What is kept; `None` before anything is, or if the note is damaged."""
        try:
            members = json.loads((self.folder / NOTE).read_text(encoding="utf-8"))
            note = Note(**{**members, "rates": Rates(**members["rates"])})
        except (OSError, ValueError, TypeError, KeyError):
            return None
        return note if (self.folder / note.file).is_file() else None

    def artifact(self, note: Note) -> bytes:
        """The artifact that a note names."""
        return (self.folder / note.file).read_bytes()

    def refresh(self, client: Client, database: str) -> bool:
        """Fetch the version in use if it isn't kept; whether it was fetched.

        Raises:
            Problem: the service refuses it.
            Unreachable: it doesn't answer.

        """
        number = client.number(database)
        kept = self.note
        if kept is not None and (kept.service, kept.database) != (client.url, database):
            kept = None
        artifact = client.artifact(database, number, etag=kept.etag if kept else None)
        if artifact is None:
            return False
        version = client.version(database, number)
        note = Note(
            service=client.url,
            database=database,
            kind=client.database(database).kind,
            version=number,
            digest=version.digest,
            etag=artifact.etag,
            labels=version.counts.labels,
            rates=Rates.of(version),
            file=f"{database}-{number}-{version.digest[:16]}.safetensors",
        )
        replace(self.folder / note.file, artifact.content)
        replace(self.folder / NOTE, json.dumps(asdict(note), indent=1).encode())
        for path in self.folder.glob("*.safetensors"):
            if path.name != note.file:
                path.unlink(missing_ok=True)
        return True


def replace(path: Path, content: bytes) -> None:
    """Write a file whole or not at all, also if the power fails."""
    unfinished = path.with_name(path.name + ".unfinished")
    with open(unfinished, "wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    os.replace(unfinished, path)
