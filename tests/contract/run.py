#!/usr/bin/env python3
"""Hold the running service against its OpenAPI document, with schemathesis and all its checks.

    tests/contract/run.py --schemathesis PROGRAM [--binary PROGRAM] [--examples 20] [--seconds N]
    tests/contract/run.py --refusals [--binary PROGRAM]

The first starts the binary on a folder of its own and fills it with a database of each kind, a calibration, a workcell, a
track and jobs, so that paths with parameters lead somewhere. So many test cases an operation, the same in every run; with
--seconds it goes on with others until the time is over. Every call carries a key of scope admin.
The second asks every operation of the document without a key: 401 everywhere but at the health.
"""

import argparse
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import pictures  # noqa: E402

OPEN = {"/livez", "/readyz", "/v2/health/live", "/v2/health/ready"}


class Service:
    """The binary on a temporary folder, on a port that the system chooses."""

    def __init__(self, binary: Path):
        self.folder = tempfile.TemporaryDirectory(prefix="landmarkd-contract-")
        self.binary = binary
        made = self.run("keys", "create", "--data-dir", self.folder.name, "--name", "contract", "--scope", "admin")
        self.key = made.strip()
        command = [binary, "serve", "--bind", "127.0.0.1:0", "--data-dir", self.folder.name, "--log-format", "json"]
        self.log_path = Path(self.folder.name) / "log"
        self.process = subprocess.Popen(
            command, env=without_settings(), stdout=subprocess.DEVNULL, stderr=self.log_path.open("wb")
        )
        self.url = f"http://{self.address()}"
        self.document = json.loads(self.run("openapi"))

    def run(self, *words: str) -> str:
        """What the binary prints."""
        return subprocess.run(
            [self.binary, *words], env=without_settings(), check=True, stdout=subprocess.PIPE, text=True
        ).stdout

    def address(self) -> str:
        """Where it listens, once it does."""
        for _ in range(600):
            for line in self.log_path.read_text().splitlines():
                if found := re.search(r'"address":"([^"]+)"', line):
                    return found[1]
            if self.process.poll() is not None:
                break
            time.sleep(0.05)
        raise SystemExit(f"the service doesn't start:\n{self.log_path.read_text()}")

    def ask(self, method: str, path: str, body: bytes = b"", media_type: str = "application/json", key: bool = True):
        """Status and body of an answer."""
        request = urllib.request.Request(self.url + path, data=body or None, method=method)
        request.add_header("Content-Type", media_type)
        if key:
            request.add_header("Authorization", f"Bearer {self.key}")
        try:
            with urllib.request.urlopen(request, timeout=60) as answer:
                return answer.status, answer.read()
        except urllib.error.HTTPError as error:
            return error.code, error.read()

    def tell(self, method: str, path: str, body: bytes | dict = b"", media_type: str = "application/json") -> dict:
        """The JSON of an answer that must be a success."""
        if isinstance(body, dict):
            body = json.dumps(body).encode()
        status, answer = self.ask(method, path, body, media_type)
        if status >= 300:
            raise SystemExit(f"{method} {path} answers {status}: {answer.decode(errors='replace')}")
        return json.loads(answer or b"{}")

    def train(self, database: str) -> str:
        """Train, and wait until the job has ended; its id."""
        job = self.tell("POST", f"/v1/databases/{database}/trainings", {})["id"]
        self.ask("GET", f"/v1/jobs/{job}/events")
        ended = self.tell("GET", f"/v1/jobs/{job}")
        if ended["state"] != "succeeded":
            raise SystemExit(f"the training of {database} failed: {ended}")
        return job

    def fill(self) -> dict:
        """Something at every path; the values of path parameters that lead to it, by the names in schemathesis.toml."""
        options = {"interest_points": 16, "query_points": 24, "rings": 4, "sectors": 16, "dimension": 8}
        self.tell("PUT", "/v1/databases/lab", {"kind": "landmarks", "options": options | {"method": "paper"}})
        self.tell("PUT", "/v1/databases/parts", {"kind": "objects"})
        for number in range(3):
            exemplar = self.tell(
                "POST", f"/v1/databases/lab/exemplars?label=place-{number}", pictures.scene(number), "image/png"
            )["id"]
        for database in ("parts",):
            for number in range(12):
                query = f"label=thing-{number % 3}&pose_deg={30 * number}"
                self.tell("POST", f"/v1/databases/{database}/exemplars?{query}", pictures.scene(number), "image/png")
        jobs = [self.train(database) for database in ("lab", "parts")]
        self.tell("PUT", "/v1/databases/lab/aliases/tested", {"version": 1})
        optics = {"focal_length_mm": 25, "f_number": 2.8, "near_focus_mm": 529, "plane_separation_mm": 0.37,
                  "pixel_pitch_um": 29, "telecentric": True}
        self.tell("PUT", "/v1/calibrations/rig", optics)
        corners = [[10, 10], [310, 12], [8, 230], [305, 225]]
        pairs = [{"image_px": [x, y], "robot_mm": [x / 2 + 100, 300 - y / 2]} for x, y in corners]
        self.tell("PUT", "/v1/workcells/bench", {"database": "parts", "calibration": "rig", "correspondences": pairs})
        track = self.tell("POST", "/v1/databases/lab/tracks", {})["id"]
        _, artifact = self.ask("GET", "/v1/databases/lab/versions/1/artifact")
        (Path(self.folder.name) / "artifact").write_bytes(artifact)
        for database in ("spare", "spare-2"):
            self.tell("PUT", f"/v1/databases/{database}", {"kind": "landmarks"})
        return {
            "databases": ["lab", "parts"],
            "spares": ["spare", "spare-2"],
            "names": ["rig", "bench"],
            "aliases": ["current", "tested"],
            "versions": [1],
            "images": ["mean", "0"],
            "ids": [exemplar, track, *jobs],
        }

    def stop(self) -> int:
        """Its status after SIGTERM."""
        self.process.send_signal(signal.SIGTERM)
        return self.process.wait(timeout=60)


def without_settings() -> dict:
    """This process's environment without the service's settings."""
    return {name: value for name, value in os.environ.items() if not name.startswith("LANDMARKD_")}


def schemathesis(service: Service, program: str, seconds: int | None, examples: int, rest: list) -> int:
    there = service.fill()
    settings = Path(service.folder.name) / "schemathesis.toml"
    words = "".join(f"{name} = {{ values = {json.dumps(values)} }}\n" for name, values in there.items())
    settings.write_text((HERE / "schemathesis.toml").read_text() + "\n[dictionaries]\n" + words)
    environment = without_settings() | {
        "SCHEMATHESIS_HOOKS": "hooks",
        "PYTHONPATH": str(HERE),
        "CONTRACT_ARTIFACT": str(Path(service.folder.name) / "artifact"),
    }
    command = [program, "--config-file", settings, "run", service.url + "/openapi.json", "--checks", "all"]
    command += ["--seed", "1", "--max-examples", str(examples), "--warnings", "off", *rest]
    if seconds:
        command += ["--max-time", str(seconds)]
    command += ["--header", f"Authorization: Bearer {service.key}"]
    failed = subprocess.run(command, env=environment, cwd=service.folder.name).returncode
    # What was asked must not have hurt it.
    status, _ = service.ask("GET", "/livez")
    panics = [line for line in service.log_path.read_text(errors="replace").splitlines() if "panicked" in line]
    print(f"contract: /livez answers {status} afterwards, {len(panics)} panics in the log")
    for line in panics[:5]:
        print(line)
    return failed or int(status != 200 or bool(panics))


def refusals(service: Service) -> int:
    """Every operation without a key."""
    wrong = []
    asked = 0
    for path, item in service.document["paths"].items():
        for method in {"get", "put", "post", "delete", "patch"} & item.keys():
            status, _ = service.ask(method.upper(), re.sub(r"\{\w+\}", "1", path), key=False)
            asked += 1
            if (status == 401) != (path not in OPEN):
                wrong.append(f"{method.upper()} {path} answers {status}")
    print(f"contract: {asked} operations asked without a key, {len(wrong)} answered otherwise than they must")
    for line in wrong:
        print(line)
    return int(bool(wrong))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", type=Path, default=Path("target/release/landmarkd"))
    parser.add_argument("--schemathesis", default="schemathesis", help="the program")
    parser.add_argument("--seconds", type=int)
    parser.add_argument("--examples", type=int, default=20, help="test cases an operation")
    parser.add_argument("--refusals", action="store_true", help="without a key: only 401")
    arguments, rest = parser.parse_known_args()
    service = Service(arguments.binary.resolve())
    try:
        if arguments.refusals:
            return refusals(service)
        return schemathesis(service, arguments.schemathesis, arguments.seconds, arguments.examples, rest)
    finally:
        ended = service.stop()
        print(f"contract: the service ended with status {ended}")


if __name__ == "__main__":
    sys.exit(main())
