"""Absent fields: `UNSET` in the generated code, `None` everywhere else."""

from __future__ import annotations

from typing import TypeVar

from ._generated.types import UNSET, Unset

T = TypeVar("T")


def given(value: T | Unset | None) -> T | None:
    """The value, or `None` if the answer doesn't have it."""
    return None if isinstance(value, Unset) else value


def wanted(value: T | None) -> T | Unset:
    """The value for a call; `None` isn't sent."""
    return UNSET if value is None else value
