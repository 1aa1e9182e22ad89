from __future__ import annotations

import datetime
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field
from dateutil.parser import isoparse

from ..models.kind_word import KindWord, check_kind_word
from ..types import UNSET, Unset

if TYPE_CHECKING:
    from ..models.alias_body import AliasBody
    from ..models.landmark_options_body import LandmarkOptionsBody
    from ..models.object_options_body import ObjectOptionsBody


T = TypeVar("T", bound="DatabaseDetail")


@_attrs_define
class DatabaseDetail:
    """A database with what it holds."""

    name: str
    kind: KindWord
    """ What a database recognises by. """
    options: LandmarkOptionsBody | ObjectOptionsBody
    """ Options of a database, by its kind. """
    created_at: datetime.datetime
    exemplars: int
    """ Training images. """
    labels: int
    """ Distinct labels among them. """
    versions: int
    """ Trained versions. """
    aliases: list[AliasBody]
    current_version: int | None | Unset = UNSET
    """ The version that `current` points to. """
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

        exemplars = self.exemplars

        labels = self.labels

        versions = self.versions

        aliases = []
        for aliases_item_data in self.aliases:
            aliases_item = aliases_item_data.to_dict()
            aliases.append(aliases_item)

        current_version: int | None | Unset
        if isinstance(self.current_version, Unset):
            current_version = UNSET
        else:
            current_version = self.current_version

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "name": name,
                "kind": kind,
                "options": options,
                "created_at": created_at,
                "exemplars": exemplars,
                "labels": labels,
                "versions": versions,
                "aliases": aliases,
            }
        )
        if current_version is not UNSET:
            field_dict["current_version"] = current_version

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.alias_body import AliasBody
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

        exemplars = d.pop("exemplars")

        labels = d.pop("labels")

        versions = d.pop("versions")

        aliases = []
        _aliases = d.pop("aliases")
        for aliases_item_data in _aliases:
            aliases_item = AliasBody.from_dict(aliases_item_data)

            aliases.append(aliases_item)

        def _parse_current_version(data: object) -> int | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(int | None | Unset, data)

        current_version = _parse_current_version(d.pop("current_version", UNSET))

        database_detail = cls(
            name=name,
            kind=kind,
            options=options,
            created_at=created_at,
            exemplars=exemplars,
            labels=labels,
            versions=versions,
            aliases=aliases,
            current_version=current_version,
        )

        database_detail.additional_properties = d
        return database_detail

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
