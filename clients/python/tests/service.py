"""The real binary as a process of its own, on a folder and a port of its own."""

from __future__ import annotations

import json
import os
import subprocess
import threading
from collections.abc import Mapping
from pathlib import Path

BINARY = os.environ.get("LANDMARKD_BINARY", "")


def environment() -> dict[str, str]:
    """This process's environment without the service's settings."""
    return {name: value for name, value in os.environ.items() if not name.startswith("LANDMARKD_")}


class Service:
    """A service that runs until it is stopped."""

    def __init__(self, folder: Path, port: int = 0, settings: Mapping[str, str] | None = None) -> None:
        self.folder = folder
        self.process = subprocess.Popen(
            [
                BINARY,
                "serve",
                "--bind",
                f"127.0.0.1:{port}",
                "--data-dir",
                folder,
                "--threads",
                "2",
                "--log-format",
                "json",
            ],
            env=environment() | dict(settings or {}),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        self.log: list[str] = []
        self._listens = threading.Event()
        self._address = ""
        threading.Thread(target=self._read, daemon=True).start()
        if not self._listens.wait(20) or not self._address:
            self.stop()
            raise RuntimeError("the service doesn't listen:\n" + "".join(self.log))
        self.url = f"http://{self._address}"

    def _read(self) -> None:
        assert self.process.stderr is not None
        for line in self.process.stderr:
            self.log.append(line)
            if not self._address:
                try:
                    self._address = json.loads(line).get("address", "")
                except ValueError:
                    continue
                if self._address:
                    self._listens.set()
        self._listens.set()

    @property
    def port(self) -> int:
        """Where it listens."""
        return int(self._address.rpartition(":")[2])

    def kill(self) -> None:
        """End it as a power cut would."""
        self.process.kill()
        self.process.wait()

    def stop(self) -> None:
        """End it."""
        self.process.terminate()
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.kill()


def make_key(folder: Path, scope: str) -> str:
    """A new key of the service on a folder."""
    command = [BINARY, "keys", "create", "--data-dir", str(folder), "--name", scope, "--scope", scope]
    return subprocess.run(command, env=environment(), check=True, stdout=subprocess.PIPE, text=True).stdout.strip()
