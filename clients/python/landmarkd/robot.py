"""A robot's loop: frames in, belief over places out, also while the service is away.

    python -m landmarkd.robot --service http://fleet:8080 --database home --frames photos
    python -m landmarkd.robot --service http://fleet:8080 --database home --watch /run/camera \
        --keep /var/lib/robot --local-binary /usr/bin/landmarkd

- Frames go to a track of the service, so that they add up. Where there is none, single answers add up here
  (`belief.py`).
- The newest frame wins: those that came while an answer was awaited are dropped, and counted.
- A service that is busy (429, 503) or away is asked again with exponential backoff and jitter, and never before
  `Retry-After` is over. The frame that is due then is the attempt: while the service is away, one frame in a while
  waits for `--timeout-s`.
- The version in use is kept on disk and checked every `--refresh-s` (by its ETag, so that it is sent only when it
  changed). With `--local-binary` a local service answers from it while the real one is away longer than `--patience-s`.
  The belief goes on across the change; the local service is stopped when the real one is back.

A refusal that waiting doesn't change (a wrong key, no such database, no version) ends the loop.
"""

from __future__ import annotations

import argparse
import contextlib
import logging
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from types import FrameType
from typing import Literal

from .backoff import Backoff
from .belief import Belief, Rates
from .camera import Camera
from .client import Client
from .frames import Frame, Newest, captured, played, watched
from .kept_version import KeptVersion
from .pose import PlacePose
from .problem import Problem, Unreachable
from .recognition import Recognition
from .sighting import Sighting, Source
from .stand_in import StandIn, StandInFailed
from .track import Track

log = logging.getLogger("landmarkd.robot")

Motion = Literal["auto", "path", "still"]

BAD_PICTURES = {"empty_image", "corrupt_image", "unsupported_image_format", "image_too_large", "image_too_small"}
"""Problems of one frame, not of the next. `body_too_large` isn't among them: the next is as large."""
PASSING = {408, 425, 429}
"""Statuses that are retried, beside those from 500 on."""


class Robot:
    """Asks where it is, frame by frame.

    Args:
        client: the service. Its `timeout_s` is the longest that a frame waits.
        database: which places.
        tracked: whether frames go to a track; otherwise each is asked about alone.
        motion: how the track takes the robot to move.
        camera: what frames are taken with that don't say so themselves, or the name of a kept camera: for poses.
        kept: where the version in use is kept; `None` keeps none.
        stand_in: the local service; `None` if there is none.
        refresh_s: how often the version in use is checked, in seconds.
        patience_s: how long the service may be away before the stand-in is started, in seconds.
        backoff: when to ask again after a failure.

    """

    def __init__(
        self,
        client: Client,
        database: str,
        *,
        tracked: bool = True,
        motion: Motion = "auto",
        camera: Camera | str | None = None,
        kept: KeptVersion | None = None,
        stand_in: StandIn | None = None,
        refresh_s: float = 60.0,
        patience_s: float = 1.0,
        backoff: Backoff | None = None,
    ) -> None:
        self.client = client
        self.database = database
        self.tracked = tracked
        self.motion: Motion = motion
        self.camera = camera
        self.kept = kept
        self.stand_in = stand_in
        self.refresh_s = refresh_s
        self.patience_s = patience_s
        self.unanswered = 0
        """Frames that nobody answered, or that were no pictures."""
        self.missed: Problem | Unreachable | None = None
        """Why the service didn't answer the last frame that it was asked about; `None` if it did."""
        self._backoff = backoff or Backoff()
        self._local_backoff = Backoff()
        self._away_since: float | None = None
        self._track: Track | None = None
        self._belief: Belief | None = None
        self._digest = ""
        self._unreadable: Frame | None = None
        self._stop = threading.Event()
        self._keeper: threading.Thread | None = None

    # The loop

    def sightings(self, source: Iterable[Frame], *, every_frame: bool = False) -> Iterator[Sighting]:
        """What is known after each frame that was answered, until the source ends or `close` is called.

        With `every_frame` none is dropped: each is asked about until somebody answers. For recorded frames.
        """
        self.keep_fresh()
        try:
            if every_frame:
                for frame in source:
                    while (sighting := self.see(frame)) is None and frame is not self._unreadable:
                        if self._stop.wait(0.02):
                            return
                    if sighting is None:
                        self.unanswered += 1
                    else:
                        yield counted(sighting, self.unanswered)
                return
            newest = Newest(source)
            try:
                while not self._stop.is_set() and not newest.ended:
                    if (taken := newest.take(0.2)) is None:
                        continue
                    if (sighting := self.see(taken)) is None:
                        self.unanswered += 1
                    else:
                        yield counted(sighting, newest.dropped + self.unanswered)
            finally:
                newest.close()
        finally:
            self.close()

    def run(
        self, source: Iterable[Frame], on_sighting: Callable[[Sighting], None], *, every_frame: bool = False
    ) -> None:
        """The same with a callback."""
        for sighting in self.sightings(source, every_frame=every_frame):
            on_sighting(sighting)

    def close(self) -> None:
        """End the loop, the track and the stand-in."""
        self._stop.set()
        if self._track is not None and self._backoff.due:
            # Else it ends by itself ten minutes later.
            with contextlib.suppress(Problem, Unreachable):
                self._track.end()
        self._track = None
        if self.stand_in is not None:
            self.stand_in.stop()

    # One frame

    def see(self, frame: Frame) -> Sighting | None:
        """Ask about a frame: the service if it is time to, else the stand-in. `None` if nobody answered.

        Raises:
            Problem: one that isn't retried.

        """
        try:
            if self._backoff.due and (sighting := self._by_service(frame)) is not None:
                return sighting
            if (sighting := self._by_stand_in(frame)) is not None:
                return sighting
        except Problem as problem:
            if problem.code not in BAD_PICTURES:
                raise
            log.warning("frame %s: %s", frame.id, problem)
            self.missed = problem
            self._unreadable = frame
        return None

    def _by_service(self, frame: Frame) -> Sighting | None:
        """The service's answer; `None` if it is busy or away, which is noted."""
        began = time.monotonic()
        try:
            sighting = self._on_track(frame, began) if self.tracked else self._single(frame, began)
        except Unreachable as error:
            self._missed(error, self._backoff.failed())
        except Problem as problem:
            if problem.status < 500 and problem.status not in PASSING:
                raise
            self._missed(problem, self._backoff.failed(problem.retry_after))
        else:
            self.missed = None
            if self._away_since is not None:
                log.info("%s is back after %.1f s", self.client.url, time.monotonic() - self._away_since)
                self._away_since = None
            self._backoff.succeeded()
            if self.stand_in is not None and self.stand_in.runs:
                self.stand_in.stop()
            return sighting
        return None

    def _missed(self, why: Problem | Unreachable, wait_s: float) -> None:
        """Note that the service didn't answer."""
        self.missed = why
        if self._away_since is None:
            self._away_since = time.monotonic()
        log.info("%s; asked again in %.1f s", why, wait_s)

    def _on_track(self, frame: Frame, began: float) -> Sighting:
        """The belief of the track, which is begun when there is none."""
        for _ in range(2):
            if self._track is None:
                try:
                    self._track = self.client.track(self.database, motion=self.motion)
                except Problem as problem:
                    if problem.code != "kind_conflict":
                        raise
                    log.info("a database of objects has no tracks: frames are asked about one by one")
                    self.tracked = False
                    return self._single(frame, began)
            try:
                answer = self._track.frame(
                    frame.picture,
                    camera=frame.camera or self.camera,
                    odometry=frame.odometry,
                    frame_id=frame.id,
                    stamp=frame.stamp,
                )
            except Problem as problem:
                # It ended, or the process that had it: another one, which begins anew.
                if problem.code != "unknown_track":
                    raise
                self._track = None
                continue
            if answer.counted:
                self._believe(self.client, answer).update(answer.frame_decision)
            return Sighting(
                frame_id=frame.id,
                stamp=frame.stamp,
                source="track",
                version=answer.version,
                digest=answer.digest,
                decision=answer.decision,
                belief=answer.belief,
                elsewhere=answer.elsewhere,
                frame_decision=answer.frame_decision,
                warnings=answer.warnings,
                asked_ms=1000 * (time.monotonic() - began),
                answer=answer,
                pose=place(answer),
            )
        raise Unreachable(f"{self.client.url} forgets tracks at once: are robots sent to one process each?")

    def _single(self, frame: Frame, began: float) -> Sighting:
        """The robot's own belief, by an answer of the service."""
        answer = self.client.recognise(
            self.database, frame.picture, camera=frame.camera or self.camera, frame_id=frame.id, stamp=frame.stamp
        )
        return self._own(frame, answer, self._believe(self.client, answer), "single", began)

    def _own(self, frame: Frame, answer: Recognition, belief: Belief, source: Source, began: float) -> Sighting:
        """The robot's own belief, with another answer taken in."""
        belief.update(answer.decision)
        return Sighting(
            frame_id=frame.id,
            stamp=frame.stamp,
            source=source,
            version=answer.version,
            digest=answer.digest,
            decision=belief.decision,
            belief=belief.best(),
            elsewhere=belief.elsewhere,
            frame_decision=answer.decision,
            warnings=answer.warnings,
            asked_ms=1000 * (time.monotonic() - began),
            answer=answer,
            pose=place(answer),
        )

    def _believe(self, client: Client, answer: Recognition) -> Belief:
        """The robot's own belief; begun anew when another version answers, which knows other places."""
        if self._belief is None or self._digest != answer.digest:
            note = self.kept.note if self.kept else None
            if note is not None and note.digest == answer.digest:
                self._belief = Belief(note.labels, note.rates)
            else:
                version = client.version(self.database, answer.version)
                self._belief = Belief(version.counts.labels, Rates.of(version))
            self._digest = answer.digest
        return self._belief

    # While the service is away

    def _by_stand_in(self, frame: Frame) -> Sighting | None:
        """The stand-in's answer; `None` if there is none, or not yet."""
        if self.stand_in is None or self.kept is None or self._away_since is None:
            return None
        began = time.monotonic()
        if began - self._away_since < self.patience_s or not self._local_backoff.due:
            return None
        try:
            started = not self.stand_in.runs
            local = self.stand_in.start(self.kept)
            if started:
                log.info("%s answers from the kept version in its place", local.url)
            answer = local.recognise(
                self.database,
                frame.picture,
                # It doesn't keep the cameras that the real one has by name.
                camera=camera if isinstance(camera := frame.camera or self.camera, Camera) else None,
                frame_id=frame.id,
                stamp=frame.stamp,
            )
            belief = self._believe(local, answer)
        except Problem as problem:
            if problem.code in BAD_PICTURES:
                raise
            log.warning("the local service: %s; tried again in %.1f s", problem, self._local_backoff.failed())
        except (StandInFailed, Unreachable, OSError) as error:
            self.stand_in.stop()
            log.warning("the local service: %s; tried again in %.1f s", error, self._local_backoff.failed())
        else:
            self._local_backoff.succeeded()
            return self._own(frame, answer, belief, "local", began)
        return None

    def keep_fresh(self) -> None:
        """Check the kept version from now on in a thread; `sightings` calls this, callers of `see` may."""
        if self.kept is None or self._keeper is not None:
            return
        kept = self.kept

        def keep() -> None:
            while True:
                try:
                    if kept.refresh(self.client, self.database):
                        log.info("version %s is kept", kept.note.version if kept.note else "?")
                except (Problem, Unreachable, OSError) as error:
                    log.debug("the kept version wasn't checked: %s", error)
                if self._stop.wait(self.refresh_s):
                    return

        self._keeper = threading.Thread(target=keep, name="kept-version", daemon=True)
        self._keeper.start()


def place(answer: Recognition) -> PlacePose | None:
    """The pose of an answer, if it is one in a map."""
    return answer.pose if isinstance(answer.pose, PlacePose) else None


def counted(sighting: Sighting, dropped: int) -> Sighting:
    """The sighting with the number of frames that were dropped until then."""
    return replace(sighting, dropped=dropped)


def arguments() -> argparse.ArgumentParser:
    """What the command line takes."""
    parser = argparse.ArgumentParser(
        prog="python -m landmarkd.robot", description="Say where a robot is, frame by frame."
    )
    parser.add_argument("--service", required=True, metavar="URL", help="the service; its key is LANDMARKD_KEY")
    parser.add_argument("--database", required=True, help="which places")
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--frames", type=Path, metavar="FOLDER", help="play the pictures of a folder, by name")
    source.add_argument(
        "--watch", type=Path, metavar="FOLDER", help="take the newest picture of a folder, again and again"
    )
    source.add_argument("--camera", type=int, metavar="NUMBER", help="take pictures with OpenCV")
    parser.add_argument("--rate-hz", type=float, default=5.0, help="pictures a second of --frames (%(default)s)")
    parser.add_argument(
        "--every-frame", action="store_true", help="with --frames: drop none, as fast as they are answered"
    )
    parser.add_argument("--single", action="store_true", help="no track: single answers add up here")
    parser.add_argument(
        "--motion", choices=("auto", "path", "still"), default="auto", help="of the track (%(default)s)"
    )
    parser.add_argument("--camera-name", metavar="NAME", help="what took them: a camera that the service keeps")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="keep the version in use here")
    parser.add_argument(
        "--local-binary", type=Path, metavar="FILE", help="landmarkd, to answer while the service is away"
    )
    parser.add_argument(
        "--refresh-s", type=float, default=60.0, help="look for a new version every so often (%(default)s)"
    )
    parser.add_argument(
        "--patience-s", type=float, default=1.0, help="away that long, --local-binary answers (%(default)s)"
    )
    parser.add_argument("--timeout-s", type=float, default=5.0, help="longest wait for an answer (%(default)s)")
    parser.add_argument("--robot-id", help="who asks")
    parser.add_argument("--json", action="store_true", help="lines for programs")
    parser.add_argument("--verbose", action="store_true", help="say what happens, on standard error")
    return parser


def main(words: list[str] | None = None) -> int:
    """Run the loop by the command line; the exit code."""
    parser = arguments()
    args = parser.parse_args(words)
    if args.local_binary and not args.keep:
        parser.error("--local-binary needs --keep: it answers from what is kept there")
    logging.basicConfig(
        level=logging.INFO if args.verbose else logging.WARNING, format="%(message)s", stream=sys.stderr
    )
    logging.getLogger("httpx").setLevel(logging.WARNING)
    stop = threading.Event()
    frames = (
        played(args.frames, 0 if args.every_frame else args.rate_hz)
        if args.frames
        else watched(args.watch, stop)
        if args.watch
        else captured(args.camera, stop)
    )
    kept = KeptVersion(args.keep / "version") if args.keep else None
    robot = Robot(
        Client(args.service, robot_id=args.robot_id, timeout_s=args.timeout_s),
        args.database,
        tracked=not args.single,
        motion=args.motion,
        camera=args.camera_name,
        kept=kept,
        stand_in=StandIn(args.local_binary, args.keep / "data") if args.local_binary else None,
        refresh_s=args.refresh_s,
        patience_s=args.patience_s,
    )

    def end(number: int, frame: FrameType | None) -> None:
        raise SystemExit(128 + number)

    signal.signal(signal.SIGTERM, end)
    try:
        for sighting in robot.sightings(frames, every_frame=args.every_frame):
            print(sighting.json() if args.json else sighting.line(), flush=True)
    except Problem as problem:
        print(f"landmarkd.robot: {problem}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"landmarkd.robot: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
    finally:
        stop.set()
        robot.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
