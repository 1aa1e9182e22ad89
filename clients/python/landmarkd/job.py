"""Jobs: their state, and the stream of their events."""

from __future__ import annotations

from dataclasses import dataclass

from ._generated.models import ComparisonBody, JobBody
from ._generated.models import Problem as ProblemBody
from .absent import given
from .problem import FieldFault, Problem

ENDED = ("succeeded", "failed", "cancelled")


@dataclass(frozen=True)
class Job:
    """The state of a job."""

    id: str
    state: str
    """`queued`, `running`, `succeeded`, `failed` or `cancelled`."""
    stage: str = ""
    """The stage it is in; empty before the first."""
    done: int = 0
    """Steps of the stage that are done."""
    total: int = 0
    """Steps of the stage."""
    version: int | None = None
    """The version that it made or found."""
    comparison: ComparisonBody | None = None
    """Its comparison with the version in use, with `promote="if_not_worse"`."""
    problem: Problem | None = None
    """Why it failed."""

    @property
    def ended(self) -> bool:
        """Whether it will not change any more."""
        return self.state in ENDED

    @classmethod
    def of(cls, body: JobBody) -> Job:
        """From the service's answer."""
        progress = given(body.progress)
        failure = given(body.problem)
        return cls(
            id=str(body.id),
            state=body.state,
            stage=progress.stage if progress else "",
            done=progress.done if progress else 0,
            total=progress.total if progress else 0,
            version=given(body.version),
            comparison=given(body.comparison),
            problem=problem(failure) if failure else None,
        )


class JobFailed(Exception):
    """A job ended without what it was for; `job.problem` says why if it failed."""

    def __init__(self, job: Job) -> None:
        super().__init__(f"job {job.id} {job.state}" + (f": {job.problem}" if job.problem else ""))
        self.job = job


def problem(body: ProblemBody) -> Problem:
    """A job's problem as an exception."""
    return Problem(
        body.status,
        body.code,
        title=body.title,
        detail=body.detail,
        errors=[FieldFault(fault.pointer, fault.detail) for fault in given(body.errors) or []],
        request_id=given(body.request_id),
    )
