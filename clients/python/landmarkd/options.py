"""Options of a database as a mapping; `/docs` of the service has them all."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ._generated.models import LandmarkOptionsBody
from ._generated.types import UNSET, Unset


class Options(LandmarkOptionsBody):
    """Options as they were given, whatever the kind: the service refuses unknown ones, which generated types drop."""

    def __init__(self, values: Mapping[str, Any]) -> None:
        super().__init__()
        self.values = dict(values)

    def to_dict(self) -> dict[str, Any]:
        """As the service takes them."""
        return self.values

    @classmethod
    def of(cls, values: Mapping[str, Any] | None) -> Options | Unset:
        """For a call; `None` isn't sent."""
        return UNSET if values is None else cls(values)
