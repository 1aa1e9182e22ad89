"""Options of a database as a mapping; `/docs` of the service has them all."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ._generated.models import LandmarkOptionsBody
from ._generated.types import UNSET, Unset


class Options(LandmarkOptionsBody):
    """Options as they were given, whatever the kind: one that the generated types don't know isn't lost but refused."""

    def __init__(self, told: Mapping[str, Any]) -> None:
        super().__init__()
        self.told = dict(told)

    def to_dict(self) -> dict[str, Any]:
        """As the service takes them."""
        return self.told

    @classmethod
    def of(cls, told: Mapping[str, Any] | None) -> Options | Unset:
        """For a call, which is silent about none."""
        return UNSET if told is None else cls(told)
