"""A service on the robot itself that answers from the kept version while the real one is away."""

from __future__ import annotations

import json
import os
import subprocess
import threading
from pathlib import Path

from .client import Client
from .kept_version import KeptVersion, Note

START_S = 20.0
"""Longest time until it listens, in seconds."""
STOP_S = 10.0
"""Longest time until it has ended, in seconds."""


class StandInFailed(Exception):
    """The local service can't be started."""


class StandIn:
    """`landmarkd serve` on loopback, on a port that the system chooses, over a folder of its own.

    Args:
        binary: the program.
        folder: its data; it is kept, so that a version is imported only once.

    """

    def __init__(self, binary: Path, folder: Path) -> None:
        self.binary = binary
        self.folder = folder
        self.version: Note | None = None
        """The kept version that it answers from."""
        self.client: Client | None = None
        """For asking it; `None` while it doesn't run."""
        self._process: subprocess.Popen[str] | None = None

    @property
    def runs(self) -> bool:
        """Whether it answers."""
        return self._process is not None and self._process.poll() is None and self.client is not None

    def start(self, kept: KeptVersion) -> Client:
        """Start it if it doesn't run, and let it answer from what is kept.

        Raises:
            StandInFailed: nothing is kept, or the program doesn't start.
            Problem: it refuses the artifact.

        """
        note = kept.note
        if note is None:
            raise StandInFailed("no version was fetched yet")
        client = self.client if self.runs else None
        if client is None:
            self.stop()
            # The environment's key isn't meant for it.
            client = Client(self._listening(), key="", timeout_s=30)
            self.client = client
        if self.version != note:
            client.create(note.database, "objects" if note.kind == "objects" else "landmarks")
            number = client.take_in(note.database, kept.artifact(note)).version
            client.point(note.database, number)
            self.version = note
        return client

    def _listening(self) -> str:
        """Start the program; its address once it listens."""
        command = [str(self.binary), "serve", "--bind", "127.0.0.1:0", "--data-dir", str(self.folder)]
        command += ["--log-format", "json"]
        # The settings of this machine's environment are those of another service.
        environment = {name: value for name, value in os.environ.items() if not name.startswith("LANDMARKD_")}
        try:
            process = subprocess.Popen(
                command,
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                text=True,
                errors="replace",
            )
        except OSError as error:
            raise StandInFailed(f"{self.binary} can't be run: {error}") from error
        self._process = process
        log: list[str] = []
        addresses: list[str] = []
        settled = threading.Event()

        def read() -> None:
            """Read the log to its end: a full pipe would block the program."""
            assert process.stderr is not None
            for line in process.stderr:
                address = address_of(line)
                if address and not addresses:
                    addresses.append(address)
                    settled.set()
                elif not addresses:
                    log.append(line)
            settled.set()

        threading.Thread(target=read, name="stand-in", daemon=True).start()
        settled.wait(START_S)
        if not addresses:
            self.stop()
            raise StandInFailed(f"{self.binary} doesn't listen:\n" + "".join(log[-5:]))
        return f"http://{addresses[0]}"

    def stop(self) -> None:
        """End it."""
        if self.client is not None:
            self.client.close()
        process, self._process, self.client, self.version = self._process, None, None, None
        if process is None or process.poll() is not None:
            return
        process.terminate()
        try:
            process.wait(STOP_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def address_of(line: str) -> str:
    """The address in a line of the log; empty if it has none."""
    try:
        entry = json.loads(line)
    except ValueError:
        return ""
    address = entry.get("address") if isinstance(entry, dict) else None
    return address if isinstance(address, str) else ""
