"""The service as an object: each method is one call.

Calls without a method of their own are in `landmarkd._generated.api`, and are made with `client.generated`.
"""

from __future__ import annotations

import io
import json
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from types import TracebackType
from typing import Any, Literal, TypeVar
from urllib.parse import urlsplit
from uuid import UUID

import httpx

from ._generated import AuthenticatedClient
from ._generated.api.databases import (
    begin_training,
    get_alias,
    get_database,
    get_version,
    import_version,
    put_alias,
    put_database,
)
from ._generated.api.depth import predict_optics
from ._generated.api.jobs import get_job
from ._generated.api.recognition import begin_track, end_track
from ._generated.api.service import info
from ._generated.api.workcell import inspect
from ._generated.models import (
    AliasBody,
    DatabaseBody,
    DatabaseDetail,
    DepthForm,
    ExemplarBody,
    Info,
    InspectionBody,
    InspectionForm,
    JobBody,
    LandmarkRecognitionBody,
    LandmarkTrackedFrameBody,
    NewAlias,
    NewDatabase,
    NewTrack,
    NewTraining,
    ObjectRecognitionBody,
    ObjectTrackedFrameBody,
    PredictionBody,
    PredictionRequest,
    TrackBody,
    VersionBody,
)
from ._generated.types import File
from .absent import wanted
from .artifact import Artifact
from .backoff import Backoff
from .camera import Camera
from .depth_map import PLANES, DepthMap
from .event import Event, events
from .job import Job, JobFailed
from .optics import Optics
from .options import Options
from .picture import Picture, encoded, media_type
from .pose import MapPose, Odometry
from .problem import Problem, Unreachable
from .recognition import Recognition
from .track import Track, TrackedFrame

T = TypeVar("T")

MOST_STREAMS = 20
"""How often the events of one job are requested again after a stream broke off."""


class Client:
    """A landmarkd service.

    Args:
        url: where it is, such as `http://127.0.0.1:8080`.
        key: the key that calls come with; `LANDMARKD_KEY` of the environment by default; empty for none.
        robot_id: who asks; the service's answers and records have it.
        timeout_s: longest time of a call, in seconds.
        verify: False takes any certificate: for trying out only. A path names a file of trusted ones.

    Every method raises `Problem` if the service refuses the call, and `Unreachable` if no answer comes. A client may be
    used by several threads.

    """

    def __init__(
        self,
        url: str,
        key: str | None = None,
        *,
        robot_id: str | None = None,
        timeout_s: float = 60.0,
        verify: bool | str = True,
    ) -> None:
        self.url = url.rstrip("/")
        self.robot_id = robot_id
        self.timeout_s = timeout_s
        self._far = urlsplit(self.url).hostname not in ("127.0.0.1", "::1", "localhost")
        key = os.environ.get("LANDMARKD_KEY") if key is None else key
        self._http = httpx.Client(
            base_url=self.url,
            headers={"Authorization": f"Bearer {key}"} if key else {},
            timeout=timeout_s,
            verify=verify,
            event_hooks={"response": [refuse]},
        )
        self.generated = AuthenticatedClient(base_url=self.url, token=key or "").set_httpx_client(self._http)
        """For the generated calls; they raise the same problems, but `httpx.TransportError` when no answer comes."""

    def close(self) -> None:
        """Close its connections."""
        self._http.close()

    def __enter__(self) -> Client:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    # The service

    def info(self) -> Info:
        """What the service is and takes."""
        return self._typed(Info, lambda: info.sync(client=self.generated))

    # Databases

    def create(
        self,
        database: str,
        kind: Literal["landmarks", "objects"] = "landmarks",
        options: Mapping[str, Any] | None = None,
    ) -> DatabaseBody:
        """Create a database. For one that is there: replaces its options if some are given."""
        body = NewDatabase(kind, Options.of(options))
        return self._typed(DatabaseBody, lambda: put_database.sync(database, client=self.generated, body=body))

    def database(self, database: str) -> DatabaseDetail:
        """A database with what it holds."""
        return self._typed(DatabaseDetail, lambda: get_database.sync(database, client=self.generated))

    def teach(
        self,
        database: str,
        label: str | None,
        picture: Picture,
        pose_deg: float | None = None,
        *,
        negative: bool = False,
        pose: MapPose | None = None,
        camera: Camera | str | None = None,
        size_mm: float | None = None,
        frame_id: str | None = None,
        stamp: str | None = None,
    ) -> ExemplarBody:
        """Add a training image for the next training. The same again is the same exemplar, with the newer `pose`.

        Args:
            database: its name.
            label: what is seen.
            picture: a path, a file's bytes, an open file, or an array (see `Picture`).
            pose_deg: for objects, how it is turned, in degrees [0, 360).
            negative: with `None` for the label, the picture shows nothing known: what looks like it is background.
            pose: where the camera was; with `size_mm`, where the landmark is.
            camera: what it was taken with, or the name of a kept camera.
            size_mm: for flat landmarks, the width of the picture on its plane.
            frame_id: the robot's name for it; comes back.
            stamp: when it was taken, RFC 3339 or `sec.nanosec`; comes back.

        """
        query = {
            "label": label,
            "negative": "true" if negative else None,
            "pose_deg": pose_deg,
            "size_mm": size_mm,
            **(pose.body() if pose else {}),
        }
        path = f"/v1/databases/{database}/exemplars"
        # The service keeps it as it comes.
        return self._picture(ExemplarBody.from_dict, path, picture, query, camera, frame_id, stamp, small=True)

    def train(
        self,
        database: str,
        *,
        options: Mapping[str, Any] | None = None,
        promote: Literal["always", "if_not_worse", "never"] = "always",
        calibration: Literal["wait", "background", "none"] | None = None,
        eigenspace: Literal["auto", "fit", "keep"] | None = None,
        wait: bool = True,
        on_progress: Callable[[Job], None] | None = None,
    ) -> Job:
        """Train a version from the exemplars.

        Args:
            database: its name.
            options: put over the database's for this training.
            promote: whether the alias `current` moves to the new version.
            calibration: of landmarks, whether the version is asked about its own pictures before it is published,
                after, or not. With "background" the job fails if the check does, and has its `version` all the same.
            eigenspace: of landmarks with gradient signatures, whether what is new is added to the version in use:
                "auto" from 1000 exemplars on if none have gone, "fit" never, "keep" as long as it can be.
            wait: until the job has ended; otherwise follow it with `follow`.
            on_progress: called with the job as often as it changes.

        Raises:
            JobFailed: it failed or was cancelled.

        """
        body = NewTraining(
            options=Options.of(options),
            promote=promote,
            calibration=wanted(calibration),
            eigenspace=wanted(eigenspace),
        )
        begun = self._typed(JobBody, lambda: begin_training.sync(database, client=self.generated, body=body))
        return self.follow(str(begun.id), on_progress) if wait else Job.of(begun)

    def follow(self, job: str, on_progress: Callable[[Job], None] | None = None) -> Job:
        """Follow a job to its end by its server-sent events, taken up again where they broke off.

        Raises:
            JobFailed: it failed or was cancelled.

        """
        last, backoff = "", Backoff(first_s=0.2, most_s=10)
        while backoff.failures < MOST_STREAMS:
            headers = {"Accept": "text/event-stream"} | ({"Last-Event-ID": last} if last else {})
            # The service sends something every 15 s.
            timeout = httpx.Timeout(10, read=60)
            try:
                with self._http.stream("GET", f"/v1/jobs/{job}/events", headers=headers, timeout=timeout) as stream:
                    for event in events(stream.iter_lines()):
                        last = event.id
                        backoff.succeeded()
                        state = Job.of(JobBody.from_dict(event.data))
                        if on_progress is not None:
                            on_progress(state)
                        if state.ended:
                            return succeeded(state)
            except httpx.TransportError:
                # The next call says whether the service is away.
                pass
            body = self._typed(JobBody, lambda: get_job.sync(UUID(job), client=self.generated))
            state = Job.of(body)
            if state.ended:
                return succeeded(state)
            time.sleep(backoff.failed())
        raise Unreachable(f"the events of job {job} broke off {MOST_STREAMS} times without a word between")

    def version(self, database: str, version: int | str = "current") -> VersionBody:
        """A version by its number or by the name of an alias, with the report of its training."""
        number = self.number(database, version)
        return self._typed(VersionBody, lambda: get_version.sync(database, number, client=self.generated))

    def number(self, database: str, version: int | str = "current") -> int:
        """The number of a version: of the one that an alias points to, if it is a name."""
        if isinstance(version, int):
            return version
        name = version
        return self._typed(AliasBody, lambda: get_alias.sync(database, name, client=self.generated)).version

    def point(self, database: str, version: int, alias: str = "current") -> AliasBody:
        """Point an alias to a version. Rolling back is pointing `current` to an older one."""
        return self._typed(
            AliasBody, lambda: put_alias.sync(database, alias, client=self.generated, body=NewAlias(version=version))
        )

    def artifact(self, database: str, version: int | str = "current", *, etag: str | None = None) -> Artifact | None:
        """A version as one file, by its number or by an alias; `None` if its entity tag is still `etag`."""
        number = self.number(database, version)
        answer = self._send(
            lambda: self._http.get(
                f"/v1/databases/{database}/versions/{number}/artifact",
                headers={"If-None-Match": etag} if etag else {},
            )
        )
        if answer.status_code == httpx.codes.NOT_MODIFIED:
            return None
        return Artifact(database, number, answer.headers.get("ETag", ""), answer.content)

    def take_in(self, database: str, artifact: bytes) -> VersionBody:
        """Make a version of an artifact file. The same again is the same version; no alias moves."""
        return self._typed(
            VersionBody,
            lambda: import_version.sync(database, client=self.generated, body=File(io.BytesIO(artifact))),
        )

    # Recognition

    def recognise(
        self,
        database: str,
        picture: Picture,
        *,
        alias: str | None = None,
        version: int | None = None,
        top: int = 5,
        explain: bool = False,
        camera: Camera | str | None = None,
        frame_id: str | None = None,
        stamp: str | None = None,
    ) -> Recognition:
        """Ask what a picture shows.

        Args:
            database: its name.
            picture: a path, a file's bytes, an open file, or an array (see `Picture`).
            alias: the alias whose version answers; `current` if no version is named either.
            version: number of the version that answers.
            top: most labels in `votes` or `candidates`.
            explain: whether every point's vote is wanted.
            camera: what it was taken with, or the name of a kept camera: for poses in metres.
            frame_id: the robot's name for it; comes back.
            stamp: when it was taken, RFC 3339 or `sec.nanosec`; comes back.

        """
        query = {"alias": alias, "version": version, "top": top, "explain": str(explain).lower()}
        path = f"/v1/databases/{database}/recognitions"

        def read(body: dict[str, Any]) -> Recognition:
            kind = LandmarkRecognitionBody if body["kind"] == "landmarks" else ObjectRecognitionBody
            return Recognition.of(kind.from_dict(body))

        return self._picture(read, path, picture, query, camera, frame_id, stamp)

    def track(
        self, database: str, *, motion: Literal["auto", "path", "still"] = "auto", alias: str | None = None
    ) -> Track:
        """Begin a track: the frames of a robot's way add up. `path` if exemplars were posted in the way's order."""
        body = NewTrack(motion=motion, alias=wanted(alias))
        begun = self._typed(TrackBody, lambda: begin_track.sync(database, client=self.generated, body=body))

        def add(
            picture: Picture,
            *,
            top: int,
            explain: bool,
            camera: Camera | str | None,
            odometry: Odometry | None,
            frame_id: str | None,
            stamp: str | None,
        ) -> TrackedFrame:
            query = {"top": top, "explain": str(explain).lower(), **(asdict(odometry) if odometry else {})}
            path = f"/v1/databases/{database}/tracks/{begun.id}/frames"

            def read(body: dict[str, Any]) -> TrackedFrame:
                kind = LandmarkTrackedFrameBody if body["kind"] == "landmarks" else ObjectTrackedFrameBody
                return TrackedFrame.of_track(kind.from_dict(body))

            return self._picture(read, path, picture, query, camera, frame_id, stamp)

        def end() -> None:
            self._send(lambda: end_track.sync_detailed(database, begun.id, client=self.generated))

        return Track(str(begun.id), begun.motion, begun.warnings, add, end)

    # Cameras

    def keep_camera(self, name: str, camera: Camera) -> None:
        """Keep a camera, which pictures are then sent with by its name."""
        self._send(lambda: self._http.put(f"/v1/cameras/{name}", json=camera.body()))

    def camera(self, name: str) -> Camera:
        """A kept camera."""
        return self._send(lambda: Camera.of(self._http.get(f"/v1/cameras/{name}").json()))

    def cameras(self) -> Iterator[str]:
        """The names of the kept cameras."""
        cursor: str | None = ""
        while cursor is not None:
            query = {"cursor": cursor} if cursor else {}
            page = self._send(partial(self._http.get, "/v1/cameras", params=query)).json()
            yield from (each["name"] for each in page["items"])
            cursor = page.get("next_cursor")

    def forget_camera(self, name: str) -> None:
        """Forget a kept camera."""
        self._send(lambda: self._http.delete(f"/v1/cameras/{name}"))

    # What happens

    def events(
        self,
        *,
        database: str | None = None,
        robot_id: str | None = None,
        kinds: Sequence[Literal["decision", "version", "job"]] = (),
    ) -> Iterator[Event]:
        """Decisions, versions, jobs from now on. The stream doesn't end, and is taken up again where it broke off.

        Args:
            database: of this one alone.
            robot_id: of this robot alone.
            kinds: these alone; all if there are none.

        Raises:
            Problem: the service it refuses the stream for another reason than that it is busy, which is waited for.

        """
        query = {"database": database, "robot_id": robot_id, "kind": ",".join(kinds) or None}
        asked = {name: value for name, value in query.items() if value is not None}
        last, backoff = "", Backoff(first_s=0.2, most_s=10)
        # The service sends something every 15 s.
        timeout = httpx.Timeout(10, read=60)
        while True:
            headers = {"Accept": "text/event-stream"} | ({"Last-Event-ID": last} if last else {})
            retry_after = None
            try:
                with self._http.stream("GET", "/v1/events", params=asked, headers=headers, timeout=timeout) as stream:
                    backoff.succeeded()
                    for event in events(stream.iter_lines()):
                        last = event.id
                        yield event
            except httpx.TransportError:
                # It broke off, or the service is away: it will be back.
                pass
            except Problem as problem:
                if problem.status < 500 and problem.status != httpx.codes.TOO_MANY_REQUESTS:
                    raise
                retry_after = problem.retry_after
            time.sleep(backoff.failed(retry_after))

    # Depth and workcells

    def depth(
        self,
        near: Picture,
        far: Picture,
        *,
        apertures: bool = False,
        optics: Optics | None = None,
        calibration: str | None = None,
        options: Mapping[str, Any] | None = None,
        frame_id: str | None = None,
        stamp: str | None = None,
    ) -> DepthMap:
        """Measure distances from a near- and a far-focused picture of one scene.

        Give `optics`, or the name of a `calibration`. `options` are those of the service, such as `{"median": 3}`. With
        `apertures` the pictures differ in aperture: `near` is the wide-open one, `far` the stopped-down one.
        """
        form = DepthForm(calibration=wanted(calibration))
        if apertures:
            form.wide, form.narrow = self._upload(near), self._upload(far)
        else:
            form.near, form.far = self._upload(near), self._upload(far)
        if optics is not None:
            form.optics = optics.body()
        return self._depth(form.to_multipart(), options, frame_id, stamp)

    def depth_of_stack(
        self,
        pictures: Sequence[Picture],
        *,
        optics: Optics,
        options: Mapping[str, Any] | None = None,
        frame_id: str | None = None,
        stamp: str | None = None,
    ) -> DepthMap:
        """Measure distances from three pictures and more of one scene, focused one after the other from near to far.

        `optics` has `focuses_mm` or `planes_mm`, one for each picture.
        """
        parts = DepthForm(optics=optics.body()).to_multipart()
        parts.extend(("stack", self._upload(picture).to_tuple()) for picture in pictures)
        return self._depth(parts, options, frame_id, stamp)

    def _depth(
        self, parts: list[tuple[str, Any]], options: Mapping[str, Any] | None, frame_id: str | None, stamp: str | None
    ) -> DepthMap:
        if options is not None:
            parts.append(json_part("options", dict(options)))
        robot = {"X-Robot-Id": self.robot_id, "X-Frame-Id": frame_id, "X-Stamp": stamp}
        headers = {"Accept": "application/x-npy"} | {name: value for name, value in robot.items() if value is not None}
        return DepthMap.of(
            self._send(
                lambda: self._http.post(
                    "/v1/depth-maps", params={"planes": ",".join(PLANES)}, files=parts, headers=headers
                )
            )
        )

    def predict(
        self,
        optics: Optics,
        *,
        range_mm: tuple[float, float] | None = None,
        contrast: float | None = None,
        noise_sigma: float | None = None,
    ) -> PredictionBody:
        """What an optics would measure, before it is built: expected errors by distance, working range, what to change.

        `contrast` and `noise_sigma` are standard deviations in gray levels of 255.
        """
        request = PredictionRequest(
            optics=optics.body(),
            range_mm=wanted(None if range_mm is None else list(range_mm)),
            contrast=wanted(contrast),
            noise_sigma=wanted(noise_sigma),
        )
        return self._typed(PredictionBody, lambda: predict_optics.sync(client=self.generated, body=request))

    def inspect(
        self,
        workcell: str,
        overview: Picture,
        *,
        near: Picture | None = None,
        far: Picture | None = None,
        region: int | None = None,
        pair_view: Literal["local", "overview"] | None = None,
        alias: str | None = None,
        version: int | None = None,
        frame_id: str | None = None,
        stamp: str | None = None,
    ) -> InspectionBody:
        """Find every part on the table: what it is, how it is turned, where to reach for it (mm), how far away it is.

        A focal pair (`near`, `far`) shows one part, that of `region`, or with `pair_view="overview"` the whole table.
        """
        form = InspectionForm(overview=self._upload(overview))
        if near is not None:
            form.near = self._upload(near)
        if far is not None:
            form.far = self._upload(far)
        return self._typed(
            InspectionBody,
            lambda: inspect.sync(
                workcell,
                client=self.generated,
                body=form,
                alias=wanted(alias),
                version=wanted(version),
                region=wanted(region),
                pair_view=wanted(pair_view),
                **self._header(frame_id, stamp),
            ),
        )

    # How calls are made

    def _upload(self, picture: Picture) -> File:
        """A picture as a part of a form."""
        content = encoded(picture, self._far)
        return File(io.BytesIO(content), "picture", media_type(content))

    def _header(self, frame_id: str | None, stamp: str | None) -> dict[str, Any]:
        """The headers that go with a picture."""
        return {"x_robot_id": wanted(self.robot_id), "x_frame_id": wanted(frame_id), "x_stamp": wanted(stamp)}

    def _picture(
        self,
        read: Callable[[dict[str, Any]], T],
        path: str,
        picture: Picture,
        query: Mapping[str, Any],
        camera: Camera | str | None,
        frame_id: str | None,
        stamp: str | None,
        small: bool = False,
    ) -> T:
        """The answer to a picture, which is sent as it is, or in a form beside its camera."""
        content = encoded(picture, small or self._far)
        asked = {name: value for name, value in query.items() if value is not None}
        robot = {"X-Robot-Id": self.robot_id, "X-Frame-Id": frame_id, "X-Stamp": stamp}
        headers = {name: value for name, value in robot.items() if value is not None}
        body: dict[str, Any]
        if isinstance(camera, Camera):
            body = {"files": [("image", ("picture", content, media_type(content))), json_part("camera", camera.body())]}
        else:
            asked |= {"camera": camera} if camera else {}
            headers["Content-Type"] = media_type(content)
            body = {"content": content}
        return self._send(lambda: read(self._http.post(path, params=asked, headers=headers, **body).json()))

    def _send(self, ask: Callable[[], T]) -> T:
        """The answer to a call."""
        try:
            return ask()
        except httpx.TransportError as error:
            raise Unreachable(f"{self.url} doesn't answer: {error or type(error).__name__}") from error
        except (KeyError, TypeError, ValueError) as error:
            # What the generated code says of an answer that isn't the service's, as a proxy's may be.
            raise unexpected(error) from error

    def _typed(self, kind: type[T], ask: Callable[[], object]) -> T:
        """The answer to a call that has one type of answer."""
        answer = self._send(ask)
        if not isinstance(answer, kind):
            raise unexpected(answer)
        return answer


def refuse(response: httpx.Response) -> None:
    """Raise the problem of an answer, if it is one."""
    if response.is_error:
        response.read()
        raise Problem.of(response)


def unexpected(answer: object) -> Problem:
    """The problem for an answer that the document doesn't have, or for what is wrong with it."""
    what = repr(answer) if isinstance(answer, Exception) else type(answer).__name__
    return Problem(200, "", title="unexpected answer", detail=f"the service answered {what}")


def json_part(name: str, value: Mapping[str, Any]) -> tuple[str, Any]:
    """A part of a form that is JSON."""
    return name, (None, json.dumps(value).encode(), "application/json")


def succeeded(job: Job) -> Job:
    """The job, if it did."""
    if job.state != "succeeded":
        raise JobFailed(job)
    return job
