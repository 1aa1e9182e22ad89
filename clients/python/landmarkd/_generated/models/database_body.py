from __future__ import annotations

import datetime
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from attrs import define as _attrs_define
from attrs import field as _attrs_field
from dateutil.parser import isoparse

from ..models.kind_word import KindWord, check_kind_word

if TYPE_CHECKING:
    from ..models.landmark_options_body import LandmarkOptionsBody
    from ..models.object_options_body import ObjectOptionsBody


T = TypeVar("T", bound="DatabaseBody")


@_attrs_define
class DatabaseBody:
    """A database."""

    name: str
    kind: KindWord
    """ What a database recognises by. """
    options: LandmarkOptionsBody | ObjectOptionsBody
    """ Options of a database, by its kind. """
    created_at: datetime.datetime
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        from ..models.landmark_options_body import LandmarkOptionsBody

        name = self.name

        kind: str = self.kind

        options: dict[str, Any]
        if isinstance(self.options, LandmarkOptionsBody):
            options = self.options.to_dict()
        else:
            options = self.options.to_dict()

        created_at = self.created_at.isoformat()

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "name": name,
                "kind": kind,
                "options": options,
                "created_at": created_at,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.landmark_options_body import LandmarkOptionsBody
        from ..models.object_options_body import ObjectOptionsBody

        d = dict(src_dict)
        name = d.pop("name")

        kind = check_kind_word(d.pop("kind"))

        def _parse_options(data: object) -> LandmarkOptionsBody | ObjectOptionsBody:
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                componentsschemas_options_body_type_0 = LandmarkOptionsBody.from_dict(data)

                return componentsschemas_options_body_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            if not isinstance(data, dict):
                raise TypeError()
            componentsschemas_options_body_type_1 = ObjectOptionsBody.from_dict(data)

            return componentsschemas_options_body_type_1

        options = _parse_options(d.pop("options"))

        created_at = isoparse(d.pop("created_at"))

        database_body = cls(
            name=name,
            kind=kind,
            options=options,
            created_at=created_at,
        )

        database_body.additional_properties = d
        return database_body

    @property
    def additional_keys(self) -> list[str]:
        return list(self.additional_properties.keys())

    def __getitem__(self, key: str) -> Any:
        return self.additional_properties[key]

    def __setitem__(self, key: str, value: Any) -> None:
        self.additional_properties[key] = value

    def __delitem__(self, key: str) -> None:
        del self.additional_properties[key]

    def __contains__(self, key: str) -> bool:
        return key in self.additional_properties
