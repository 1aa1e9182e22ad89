from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

from attrs import define as _attrs_define

from ..models.kind_word import KindWord, check_kind_word
from ..types import UNSET, Unset

if TYPE_CHECKING:
    from ..models.landmark_options_body import LandmarkOptionsBody
    from ..models.object_options_body import ObjectOptionsBody


T = TypeVar("T", bound="NewDatabase")


@_attrs_define
class NewDatabase:
    """A database to create."""

    kind: KindWord
    """ What a database recognises by. """
    options: LandmarkOptionsBody | None | ObjectOptionsBody | Unset = UNSET

    def to_dict(self) -> dict[str, Any]:
        from ..models.landmark_options_body import LandmarkOptionsBody
        from ..models.object_options_body import ObjectOptionsBody

        kind: str = self.kind

        options: dict[str, Any] | None | Unset
        if isinstance(self.options, Unset):
            options = UNSET
        elif isinstance(self.options, LandmarkOptionsBody):
            options = self.options.to_dict()
        elif isinstance(self.options, ObjectOptionsBody):
            options = self.options.to_dict()
        else:
            options = self.options

        field_dict: dict[str, Any] = {}

        field_dict.update(
            {
                "kind": kind,
            }
        )
        if options is not UNSET:
            field_dict["options"] = options

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.landmark_options_body import LandmarkOptionsBody
        from ..models.object_options_body import ObjectOptionsBody

        d = dict(src_dict)
        kind = check_kind_word(d.pop("kind"))

        def _parse_options(data: object) -> LandmarkOptionsBody | None | ObjectOptionsBody | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                componentsschemas_options_body_type_0 = LandmarkOptionsBody.from_dict(data)

                return componentsschemas_options_body_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                componentsschemas_options_body_type_1 = ObjectOptionsBody.from_dict(data)

                return componentsschemas_options_body_type_1
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(LandmarkOptionsBody | None | ObjectOptionsBody | Unset, data)

        options = _parse_options(d.pop("options", UNSET))

        new_database = cls(
            kind=kind,
            options=options,
        )

        return new_database
