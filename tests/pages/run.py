#!/usr/bin/env python3
"""Do what the pages say, as a newcomer would: every command of every block, in the page's order, on the real binary.

    tests/pages/run.py BINARY [--venv DIR]
    tests/pages/run.py --list

A page has a temporary folder and a shell's variables of its own. Blocks of sh and python are run, a block of toml is
served with, the answer that a block of json stands for is asked for and held against it. A command must exit with 0, and
an answer to curl be below 400; a job that is followed must succeed. What can't be run here stands in NOT_RUN with the
reason; an entry that no command of the page begins with any more is a failure, and so is a page with commands that isn't
in PAGES. `cargo run` is BINARY, or the example beside it. Addresses, folders and ids of the pages are replaced, see
`Page.here`. Blocks of Python need --venv, into which the pages' own `pip install` puts the client; it is made if it
isn't there.
--list says what would be run and what not.
"""

import argparse
import datetime
import json
import os
import re
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGES = [
    "README.md",
    "CONTRIBUTING.md",
    "docs/robots.md",
    "docs/bags.md",
    "docs/operating.md",
    "clients/python/README.md",
    "clients/typescript/README.md",
    "clients/ros2/landmarkd_ros/README.md",
    "clients/vda5050/README.md",
    "tests/browser/README.md",
]

BY_CI = "a step of .ci/run, or of a release, of its own"
FLEET = "needs PostgreSQL and a bucket; tests/fleet runs a fleet"
NODE = "needs Node; clients/test.sh does it"
ROS = "needs ROS 2"
BAG = "needs a bag; tests/bags writes some"
BROKER = "needs an MQTT broker; clients/test.sh runs one"
# How a command begins, by page, and why it isn't run. A block in no language that is run here counts as one command.
NOT_RUN = {
    "README.md": {"cargo test": BY_CI},
    "CONTRIBUTING.md": {"cargo build": BY_CI, "cargo run": "README.md has it", "just ": BY_CI, ".ci/run": "runs this"},
    "docs/robots.md": {
        "landmarkd serve &": BAG,
        "landmarkd teach": BAG,
        "landmarkd ask": BAG,
        "file,map,x_m": "a table",
    },
    "docs/bags.md": dict.fromkeys(["landmarkd serve", "landmarkd teach", "landmarkd ask", "landmarkd evaluate"], BAG),
    "docs/operating.md": {
        "<data-dir>/lock": "no command",
        "export AWS_ENDPOINT_URL": FLEET,
        "export LANDMARKD_CATALOGUE": FLEET,
        "landmarkd serve --role serve": FLEET,
        "landmarkd serve --role train": FLEET,
        "pg_dump": FLEET,
        "pg_restore": FLEET,
        "aws s3 sync": FLEET,
    },
    "clients/python/README.md": {"clients/test.sh": BY_CI},
    "clients/typescript/README.md": {"npm ci": NODE, "npm run": NODE, "import {": NODE},
    "clients/ros2/landmarkd_ros/README.md": {
        "pip install ./clients/python": ROS,
        "ln -s": ROS,
        "cd ~/ros2_ws": ROS,
        "ros2 launch": ROS,
        "ros2 param": ROS,
        "ros2 service": ROS,
        "ros2 topic": ROS,
        "docker build": "needs Docker and a network",
    },
    "clients/vda5050/README.md": {
        "pip install": BROKER,
        "python -m landmarkd_vda5050": BROKER,
    },
    "tests/browser/README.md": {"cargo build": BY_CI, "tests/browser/run.sh": BY_CI},
}
# What stands in for a block of json: the command that answers so.
ANSWERS = {
    "docs/robots.md": [
        "curl --data-binary @frame.jpg -H 'Content-Type: image/jpeg' http://127.0.0.1:8080/v1/databases/home/recognitions"
    ],
}
# What a command must print, by how it begins.
PRINTS = {
    "README.md": {
        "curl --data-binary @frame.jpg -H 'Content-Type: image/jpeg' $DB/recognitions": r'"decision":\{"label":"kitchen"',
        "cargo run --release -- evaluate photos": r"top-1 +1\.000",
        "cargo run --release --example recognise_place": r"kitchen \(confidence",
        "from landmarkd import Client": r"^kitchen$",
    },
    "docs/robots.md": {
        "from landmarkd import Client": r"^kitchen$",
        "curl --data-binary @part.png": r'"decision":\{"label":"truck"',
        "curl -F overview=@table.png $CELL/inspections": r'"decision":\{"label":"mug"',
        "curl $SERVICE/v1/depth-maps -F near=": r'"coverage":0\.[89]',
    },
    "docs/operating.md": {
        "landmarkd keys create": r"^lmk_[0-9a-f_]+$",
        "landmarkd verify": r"^2 exemplars and 3 versions are whole$",
    },
    "clients/python/README.md": {
        "from landmarkd import Client": r"^kitchen$",
        "python -m landmarkd.robot": r"kitchen",
    },
}


def learnt(database: str, thing: str, robot: str) -> list[str]:
    """How a robot teaches a thing, and a version more knows it."""
    service = "http://127.0.0.1:8080"
    to = f"{service}/v1/databases/{database}"
    picture = f"--data-binary @views/{thing}/turned__0.png -H 'Content-Type: image/png' -H 'X-Robot-Id: {robot}'"
    return [
        f"curl {picture} '{to}/exemplars?label={thing}'",
        f"JOB=$(curl -o /dev/null -w '%header{{location}}' -X POST {to}/trainings -H 'Content-Type: application/json' -d '{{}}')",
        f"curl -N {service}$JOB/events",
    ]


# What a page takes to be there, below which heading: run before the first block under it. `pictures` draws no new ones: they
# are those of the demo that README.md begins with.
GIVEN = {
    ("README.md", "Your own pictures"): ["pictures", "pip install ./clients/python"],
    ("docs/robots.md", "From a recorded bag to a robot that relocalises"): ["taught", "landmarkd serve"],
    ("docs/operating.md", "Un-learning"): [
        "taught",
        "landmarkd serve --data-dir /var/lib/landmarkd",
        """curl -X PUT http://127.0.0.1:8080/v1/databases/lab -H 'Content-Type: application/json' -d '{"kind": "landmarks"}'""",
        *learnt("lab", "mug", "r7"),
        *learnt("lab", "house", "r8"),
        *learnt("lab", "truck", "r8"),
    ],
    ("clients/python/README.md", "landmarkd for Python"): ["taught", "landmarkd serve"],
}
# Commands that go on: a server until another takes its place or the page ends, any other until it printed something; and
# the exit codes of one that is ended with Ctrl-C.
SERVERS = r"(cargo run --release --|landmarkd) (serve|demo)\b"
GOES_ON = rf"{SERVERS}|python -m landmarkd\.robot"
ENDED = (0, 130)

CURL = """#!/bin/sh
# As the pages say, a key goes with every call once there is one.
exec {curl} -sS --fail-with-body ${{KEY:+-H "Authorization: Bearer $KEY"}} "$@"
"""
CARGO = """#!/bin/sh
# cargo run --release [--example NAME] -- WORD...
[ "$1 $2" = "run --release" ] || {{ echo "not here: cargo $*" >&2; exit 99; }}
shift 2
program={binary}
if [ "$1" = --example ]; then program={examples}/$2; shift 2; fi
[ "$1" = -- ] && shift
exec "$program" "$@"
"""


class Failed(Exception):
    """A command that didn't do what the page says."""


@dataclass
class Block:
    """A fenced block of a page."""

    page: str
    line: int
    language: str
    heading: str
    text: str

    def commands(self) -> list[str]:
        """What is run, or not, as one: of a shell's block each command, else the whole."""
        if self.language != "sh":
            return [self.text]
        commands, waiting = [], ""
        for line in self.text.splitlines(keepends=True):
            waiting += line
            if is_complete(waiting):
                commands.append(waiting.strip())
                waiting = ""
        if waiting:
            raise Failed(f"{self.page}:{self.line}: a quote isn't closed")
        return [command for command in commands if command and not command.startswith("#")]


def is_complete(command: str) -> bool:
    """Whether a shell would run it, or wait for more lines."""
    if command.rstrip().endswith("\\"):
        return False
    try:
        shlex.split(command, comments=True)
    except ValueError:
        return False
    return True


def blocks_of(page: str) -> list[Block]:
    blocks: list[Block] = []
    heading, open_block = "", None
    for number, line in enumerate((ROOT / page).read_text().splitlines(), 1):
        if open_block is not None:
            if line.startswith("```"):
                blocks.append(open_block)
                open_block = None
            else:
                open_block.text += line + "\n"
        elif line.startswith("```"):
            open_block = Block(page, number, line[3:].strip(), heading, "")
        elif found := re.match(r"#+ (.*)", line):
            heading = found[1]
    return blocks


def reason_not_to(page: str, command: str) -> str | None:
    for start, reason in NOT_RUN.get(page, {}).items():
        if command.startswith(start):
            return reason
    return None


def faults_of_the_tables() -> list[str]:
    """What the tables name and no page has, and what pages have and no table names."""
    faults = []
    for page in pages_with_commands():
        if page not in PAGES:
            faults.append(f"{page} has commands and isn't in PAGES")
    for page in PAGES:
        blocks = blocks_of(page)
        commands = [command for block in blocks for command in block.commands()]
        for table, name in ((NOT_RUN, "NOT_RUN"), (PRINTS, "PRINTS")):
            for start in table.get(page, {}):
                if not any(command.startswith(start) for command in commands):
                    faults.append(f"{name}: no command of {page} begins with {start!r}")
        for at, heading in GIVEN:
            if at == page and heading not in {block.heading for block in blocks}:
                faults.append(f"GIVEN: {page} has no blocks below {heading!r}")
        samples = [block for block in blocks if block.language == "json"]
        if len(samples) != len(ANSWERS.get(page, [])):
            faults.append(f"ANSWERS: {page} has {len(samples)} blocks of json")
        for block in blocks:
            if block.language not in ("sh", "python", "toml", "json") and reason_not_to(page, block.text) is None:
                faults.append(f"{page}:{block.line}: the block is neither run nor in NOT_RUN")
    return faults


def pages_with_commands() -> list[str]:
    found = []
    for folder, folders, files in os.walk(ROOT):
        folders[:] = [name for name in folders if name not in ("node_modules", "target") and not name.startswith(".")]
        for path in (Path(folder) / name for name in files if name.endswith(".md")):
            if re.search(r"^```(sh|bash|shell|console|python)$", path.read_text(), re.MULTILINE):
                found.append(str(path.relative_to(ROOT)))
    return found


@dataclass
class Tools:
    """What the commands find in PATH, and where."""

    binary: Path
    venv: Path | None
    folder: Path

    def __post_init__(self):
        self.folder.mkdir()
        examples = self.binary.parent / "examples"
        self.write("cargo", CARGO.format(binary=shlex.quote(str(self.binary)), examples=shlex.quote(str(examples))))
        self.write("curl", CURL.format(curl=shlex.quote(shutil.which("curl") or "curl")))
        (self.folder / "landmarkd").symlink_to(self.binary)
        if self.venv is not None and not (self.venv / "bin/python").exists():
            subprocess.run([sys.executable, "-m", "venv", self.venv], check=True)

    def write(self, name: str, text: str):
        path = self.folder / name
        path.write_text(text)
        path.chmod(0o755)

    def reason_not_to(self, command: str, language: str) -> str | None:
        """What is missing here and now for a command."""
        if self.venv is None and (language == "python" or re.match(r"pip |python ", command)):
            return "no --venv was given"
        example = re.match(r"cargo run --release --example (\S+)", command)
        if example and not (self.binary.parent / "examples" / example[1]).exists():
            return "the example isn't built beside the binary"
        return None

    def environment(self) -> dict[str, str]:
        kept = {name: value for name, value in os.environ.items() if not name.startswith(("LANDMARKD_", "AWS_"))}
        path = [str(self.folder), *([f"{self.venv}/bin"] if self.venv else []), kept.get("PATH", "/usr/bin:/bin")]
        return kept | {"PATH": ":".join(path), "PYTHONDONTWRITEBYTECODE": "1", "PIP_DISABLE_PIP_VERSION_CHECK": "1"}


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


@dataclass
class GoingOn:
    """A command that was begun and hasn't ended."""

    command: str
    process: subprocess.Popen
    log: Path

    def when(self, ready: Callable[[str], object]) -> str:
        """Its output when it is ready."""
        for _ in range(3000):
            output = self.log.read_text()
            if ready(output):
                return output
            if self.process.poll() is not None:
                raise Failed(f"ended with {self.process.returncode}\n{tail(output)}")
            time.sleep(0.1)
        raise Failed(f"isn't there after five minutes\n{tail(output)}")

    def end(self):
        """As Ctrl-C does."""
        if self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGINT)
        try:
            code = self.process.wait(30)
        except subprocess.TimeoutExpired:
            os.killpg(self.process.pid, signal.SIGKILL)
            self.process.wait()
            raise Failed(f"{first_line(self.command)}: Ctrl-C doesn't end it\n{tail(self.log.read_text())}") from None
        if code not in ENDED:
            raise Failed(f"{first_line(self.command)}: ended with {code}\n{tail(self.log.read_text())}")


class Page:
    """A newcomer at one page: a folder, a shell's variables, what was begun."""

    def __init__(self, name: str, tools: Tools, folder: Path, taught: Path):
        self.name = name
        self.tools = tools
        self.folder = folder
        self.taught = taught
        self.ports = {"127.0.0.1:8080": free_port(), "127.0.0.1:9000": free_port()}
        self.variables = tools.environment() | {"LANDMARKD_BIND": f"127.0.0.1:{self.ports['127.0.0.1:8080']}"}
        self.python = ""
        self.revoked = ""
        self.server: GoingOn | None = None
        self.samples = list(ANSWERS.get(name, []))
        folder.mkdir()
        if self.tools.venv is not None:
            left_out = shutil.ignore_patterns("node_modules", "build", "*.egg-info", "__pycache__", "_generated")
            shutil.copytree(ROOT / "clients", folder / "clients", ignore=left_out)
            shutil.copytree(ROOT / "openapi", folder / "openapi")
        for path in ("var/lib", "backups", "run/camera"):
            (folder / path).mkdir(parents=True)

    def here(self, text: str) -> str:
        """A page's text with the addresses, folders, ids and times that are true here."""
        day = datetime.timedelta(days=1)
        today = datetime.datetime.now(datetime.timezone.utc).replace(microsecond=0)
        replaced = {address: f"127.0.0.1:{port}" for address, port in self.ports.items()}
        replaced["fleet:8080"] = replaced["127.0.0.1:8080"]
        replaced |= {path: f"{self.folder}{path}" for path in ("/var/lib/", "/backups/", "/run/camera")}
        replaced["/usr/bin/landmarkd"] = str(self.tools.binary)
        replaced["2026-03-01T00:00:00Z"] = f"{today - day:%Y-%m-%dT%H:%M:%SZ}"
        replaced["2026-03-02T00:00:00Z"] = f"{today + day:%Y-%m-%dT%H:%M:%SZ}"
        if self.revoked:
            replaced["2f6b1c09d4e7a853"] = self.revoked
        for there, put in replaced.items():
            text = text.replace(there, put)
        return text

    def run(self, command: str, language: str) -> str:
        """Do it; what it printed."""
        match language:
            case "sh" if re.match(GOES_ON, command):
                printed = self.begin(command)
            case "sh":
                printed = self.shell(self.here(command))
            case "python":
                # One session a page: what a block names is there in the next.
                self.python += self.here(command)
                (self.folder / "session.py").write_text(self.python)
                printed = self.shell("python session.py")
            case "toml":
                printed = self.serve_with(command)
            case _:
                printed = self.shell(self.here(self.samples.pop(0)))
                hold(json.loads(printed), elided(command), "the answer")
        self.judge(command, printed)
        self.remember(command, printed)
        return printed

    def shell(self, command: str) -> str:
        """Run in bash with the variables of the commands before, and keep those that it sets."""
        kept = self.folder / ".variables"
        script = f"set -a -o pipefail\ntrap 'code=$?; env -0 >{shlex.quote(str(kept))}; exit $code' EXIT\n{command}\n"
        try:
            done = subprocess.run(
                ["bash", "-c", script],
                cwd=self.folder,
                env=self.variables,
                timeout=300,
                stdin=subprocess.DEVNULL,
                capture_output=True,
            )
        except subprocess.TimeoutExpired:
            raise Failed("doesn't end") from None
        printed = done.stdout.decode(errors="replace")
        if done.returncode != 0:
            raise Failed(f"exit code {done.returncode}\n{tail(done.stderr.decode(errors='replace') + printed)}")
        entries = (entry.partition("=") for entry in kept.read_text().split("\0") if entry)
        self.variables = {name: value for name, _, value in entries if name not in ("_", "code", "SHLVL")}
        return printed

    def begin(self, command: str) -> str:
        """Begin what goes on, and wait until it is of use. What isn't a server is ended then."""
        port = self.ports["127.0.0.1:8080"]
        if not re.match(SERVERS, command):
            begun = self.started(command, ["bash", "-c", f"exec {self.here(command)}"], self.variables)
            try:
                return begun.when(lambda output: re.search(PRINTS[self.name][start_of(self.name, command)], output))
            finally:
                begun.end()
        self.stop()
        self.server = self.started(command, ["bash", "-c", f"exec {self.here(command)}"], self.variables)
        # The demo answers from its beginning, and is done when it says how to end it.
        done = "until Ctrl-C" if "demo" in command else ""
        return self.server.when(lambda output: done in output and answers(port))

    def started(self, command: str, words: list, variables: dict[str, str]) -> GoingOn:
        log = self.folder / "going-on.log"
        with log.open("wb") as out:
            process = subprocess.Popen(
                words,
                cwd=self.folder,
                env=variables,
                stdin=subprocess.DEVNULL,
                stdout=out,
                stderr=out,
                start_new_session=True,
            )
        return GoingOn(command, process, log)

    def stop(self):
        server, self.server = self.server, None
        if server is not None:
            server.end()

    def serve_with(self, settings: str) -> str:
        """Serve with a file of settings, named as its first line says."""
        found = re.match(r"# (\S+\.toml)\n", settings)
        if found is None:
            raise Failed("the first line doesn't name the file")
        (self.folder / found[1]).write_text(self.here(settings))
        variables = {name: value for name, value in self.variables.items() if not name.startswith("LANDMARKD_")}
        begun = self.started(settings, [self.tools.binary, "serve", "--config", found[1]], variables)
        try:
            return begun.when(lambda output: answers(self.ports["127.0.0.1:9000"]))
        finally:
            begun.end()

    def judge(self, command: str, printed: str):
        """Whether it printed what the page leads one to expect."""
        if "/events" in command and '"state":"succeeded"' not in printed:
            raise Failed(f"the job didn't succeed\n{tail(printed)}")
        start = start_of(self.name, command)
        if start and not re.search(PRINTS[self.name][start], printed, re.MULTILINE):
            raise Failed(f"doesn't print {PRINTS[self.name][start]}\n{tail(printed)}")

    def remember(self, command: str, printed: str):
        """What a person copies from one command's output into the next."""
        if "keys create --name operator" in command:
            self.variables["KEY"] = printed.strip()
        if "keys list" in command and (found := re.search(r"^([0-9a-f]{16}) .*robot 7", printed, re.MULTILINE)):
            self.revoked = found[1]

    def given(self, what: str):
        """What the page takes to be there."""
        if what == "pictures":
            lay_out_pictures(self.folder / "landmarkd-demo/pictures", self.folder, self.ports["127.0.0.1:8080"])
        elif what == "taught":
            shutil.copytree(self.taught, self.folder, dirs_exist_ok=True)
            shutil.copy(self.folder / "frame.jpg", self.folder / "run/camera/0001.jpg")
        elif self.tools.reason_not_to(what, "sh") is None:
            self.run(what, "sh")

    def hand_on(self):
        """Leave what was taught here to the pages that go on from it: pictures, and the database `home`."""
        self.stop()
        left = shutil.ignore_patterns("clients", "openapi", "var", "run", "backups", "maps", "landmarkd-demo", "session.py")
        shutil.copytree(self.folder, self.taught, ignore=left)


def start_of(page: str, command: str) -> str | None:
    return next((start for start in PRINTS.get(page, {}) if command.startswith(start)), None)


def answers(port: int) -> bool:
    try:
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/readyz", timeout=5) as answer:
            return answer.status == 200
    except OSError:
        return False


def lay_out_pictures(drawn: Path, folder: Path, port: int):
    """The pictures that the pages take to be there, from those that the demo drew."""

    def copy(source: Path, put: str):
        (folder / put).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, folder / put)

    rooms = ("kitchen", "office", "library")
    for room in rooms:
        # The bytes decide what a picture is, not the name: these are PNG.
        copy(next((drawn / "demo-rooms/learned").glob(f"*-{room}.png")), f"photos/{room}/1.jpg")
    for asked in sorted((drawn / "demo-rooms/asked").iterdir()):
        shown = asked.stem.partition("-")[2].replace("strange", "unknown")
        if shown in (*rooms, "unknown"):
            copy(asked, f"more-photos/{shown}/{asked.name}")
    copy(drawn / "demo-rooms/asked/000-kitchen.png", "frame.jpg")
    for name in ("near.png", "far.png", "optics.json"):
        copy(drawn / "demo-depth/floor" / name, name)
    # The demo has one focal pair of each scene: what two apertures and a middle setting are asked with only has their form.
    for name, picture in (("f2.8.png", "floor/near"), ("f8.png", "floor/far"), ("middle.png", "hollow/near")):
        copy(drawn / f"demo-depth/{picture}.png", name)
    shutil.copytree(drawn / "demo-turntable/learned", folder / "views")
    shutil.copytree(drawn / "demo-turntable/asked", folder / "more-views")
    copy(drawn / "demo-workcell/table.png", "table.png")
    copy(drawn / "demo-workcell/gripper-0.png", "gripper.png")
    copy(drawn / "demo-workcell/table.png", "poster.png")
    # Those that the table's parts were learnt from are in the demo's database alone. One of them is asked about.
    exemplars = f"http://127.0.0.1:{port}/v1/databases/demo-workcell/exemplars"
    with urllib.request.urlopen(f"{exemplars}?limit=1000") as answer:
        listed = json.load(answer)["items"]
    for exemplar in listed:
        with urllib.request.urlopen(f"{exemplars}/{exemplar['id']}/image") as answer:
            picture = answer.read()
        label, pose_deg = exemplar["label"], exemplar["pose_deg"]
        asked = (label, pose_deg) == ("truck", 130)
        path = folder / ("part.png" if asked else f"turntable/{label}/{label}__{pose_deg:g}.png")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(picture)


def elided(sample: str) -> object:
    """A sample's JSON; what it leaves out with `…` is the name "…" of an object and the element "…" of a list."""
    text = re.sub(r"\[\s*…\s*\]", '["…"]', sample)
    text = re.sub(r"(?<=\{)\s*…\s*(?=\})", '"…": 0', text)
    text = re.sub(r",\s*…\s*(?=\})", ', "…": 0', text)
    text = re.sub(r",\s*…\s*(?=\])", ', "…"', text)
    return json.loads(text)


def hold(answer: object, sample: object, where: str):
    """Whether an answer has what the sample shows: each name, with a value of that type, and no other unless elided."""
    if isinstance(sample, dict):
        if not isinstance(answer, dict):
            raise Failed(f"{where} is {answer!r:.60}, in the sample an object")
        for name in sample.keys() - {"…"}:
            if name not in answer:
                raise Failed(f"{where} has no {name!r}")
            hold(answer[name], sample[name], f"{where}.{name}")
        if "…" not in sample and (more := answer.keys() - sample.keys()):
            raise Failed(f"{where} has {', '.join(sorted(more))} too")
    elif isinstance(sample, list):
        if not isinstance(answer, list):
            raise Failed(f"{where} is {answer!r:.60}, in the sample a list")
        for n, element in enumerate(sample):
            if element == "…":
                break
            if not answer:
                raise Failed(f"{where} is empty")
            # Elements are alike: where the answer has fewer, its last one stands for the others.
            n = min(n, len(answer) - 1)
            hold(answer[n], element, f"{where}[{n}]")
    elif kind(answer) != kind(sample):
        raise Failed(f"{where} is {answer!r:.60}, in the sample {sample!r:.60}")


def kind(value: object) -> type:
    return float if isinstance(value, int) and not isinstance(value, bool) else type(value)


def first_line(command: str) -> str:
    """For a line of the report, without a comment at its end."""
    lines = command.strip().splitlines()
    line = re.sub(r"\s+# .*$", "", lines[0])
    return line if len(line) <= 70 else line[:69] + "…"


def tail(text: str) -> str:
    return "\n".join(f"      | {line[:300]}" for line in text.strip().splitlines()[-12:])


@dataclass
class Tally:
    blocks: int = 0
    run: int = 0
    partly: int = 0
    failures: int = 0


def do_page(name: str, tools: Tools, folder: Path, taught: Path, tally: Tally):
    page = Page(name, tools, folder, taught)
    given = {heading: what for (at, heading), what in GIVEN.items() if at == name}
    try:
        for block in blocks_of(name):
            for what in given.pop(block.heading, []):
                try:
                    page.given(what)
                except Failed as failure:
                    tally.failures += 1
                    print(f"{name}:{block.line}: FAILED, given before: {first_line(what)}: {failure}", flush=True)
            do_block(block, page, tally)
        if name == "README.md":
            page.hand_on()
    finally:
        try:
            page.stop()
        except Failed as failure:
            tally.failures += 1
            print(f"{name}: FAILED: {failure}", flush=True)


def do_block(block: Block, page: Page, tally: Tally):
    commands, notes, failed, run, began = block.commands(), [], 0, 0, time.monotonic()
    for command in commands:
        if reason := reason_not_to(block.page, command) or page.tools.reason_not_to(command, block.language):
            notes.append(f"    not run: {first_line(command)}: {reason}")
            continue
        run += 1
        try:
            page.run(command, block.language)
        except Failed as failure:
            failed += 1
            notes.append(f"    FAILED: {first_line(command)}: {failure}")
    in_part = f"run in part, {run} of {len(commands)} commands"
    how = "not run" if run == 0 else "run" if run == len(commands) else in_part
    if run:
        how += f", {time.monotonic() - began:.1f} s"
    print(f"{block.page}:{block.line}: {block.language}, {how}", *notes, sep="\n", flush=True)
    tally.blocks += 1
    tally.run += run == len(commands)
    tally.partly += 0 < run < len(commands)
    tally.failures += failed


def list_all():
    for page in PAGES:
        for block in blocks_of(page):
            for command in block.commands():
                print(f"{page}:{block.line}: {first_line(command)}: {reason_not_to(page, command) or 'run'}")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("binary", type=Path, nargs="?")
    parser.add_argument("--venv", type=Path)
    parser.add_argument("--list", action="store_true")
    arguments = parser.parse_args()
    faults = faults_of_the_tables()
    for fault in faults:
        print(f"FAILED: {fault}")
    if arguments.list:
        list_all()
        return bool(faults)
    if arguments.binary is None:
        parser.error("which binary?")

    began, tally = time.monotonic(), Tally(failures=len(faults))
    with tempfile.TemporaryDirectory(prefix="landmarkd-pages-") as temporary:
        folder = Path(temporary).resolve()
        venv = arguments.venv.resolve() if arguments.venv else None
        tools = Tools(arguments.binary.resolve(strict=True), venv, folder / "tools")
        for page in PAGES:
            do_page(page, tools, folder / page.replace("/", "-"), folder / "taught", tally)
    not_run = tally.blocks - tally.run - tally.partly
    print(
        f"\n{tally.blocks} blocks: {tally.run} run, {tally.partly} in part, {not_run} not run; "
        f"{tally.failures} failures; {time.monotonic() - began:.0f} s"
    )
    return bool(tally.failures)


if __name__ == "__main__":
    sys.exit(main())
