from __future__ import annotations

import datetime
from collections.abc import Mapping
from typing import Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field
from dateutil.parser import isoparse

from ..models.scope_word import ScopeWord, check_scope_word
from ..types import UNSET, Unset

T = TypeVar("T", bound="KeyMade")


@_attrs_define
class KeyMade:
    """A new key, shown this once."""

    id: str
    name: str
    scope: ScopeWord
    """ What a key may do; each includes the ones before it. """
    created_at: datetime.datetime
    key: str
    """ The key itself: keep it, it isn't shown again. """
    databases: list[str] | None | Unset = UNSET
    requests_per_s: int | None | Unset = UNSET
    last_used_at: datetime.datetime | None | Unset = UNSET
    """ Of other processes within a minute or so. """
    revoked_at: datetime.datetime | None | Unset = UNSET
    """ It isn't taken any more from then on. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        id = self.id

        name = self.name

        scope: str = self.scope

        created_at = self.created_at.isoformat()

        key = self.key

        databases: list[str] | None | Unset
        if isinstance(self.databases, Unset):
            databases = UNSET
        elif isinstance(self.databases, list):
            databases = self.databases

        else:
            databases = self.databases

        requests_per_s: int | None | Unset
        if isinstance(self.requests_per_s, Unset):
            requests_per_s = UNSET
        else:
            requests_per_s = self.requests_per_s

        last_used_at: None | str | Unset
        if isinstance(self.last_used_at, Unset):
            last_used_at = UNSET
        elif isinstance(self.last_used_at, datetime.datetime):
            last_used_at = self.last_used_at.isoformat()
        else:
            last_used_at = self.last_used_at

        revoked_at: None | str | Unset
        if isinstance(self.revoked_at, Unset):
            revoked_at = UNSET
        elif isinstance(self.revoked_at, datetime.datetime):
            revoked_at = self.revoked_at.isoformat()
        else:
            revoked_at = self.revoked_at

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "id": id,
                "name": name,
                "scope": scope,
                "created_at": created_at,
                "key": key,
            }
        )
        if databases is not UNSET:
            field_dict["databases"] = databases
        if requests_per_s is not UNSET:
            field_dict["requests_per_s"] = requests_per_s
        if last_used_at is not UNSET:
            field_dict["last_used_at"] = last_used_at
        if revoked_at is not UNSET:
            field_dict["revoked_at"] = revoked_at

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        id = d.pop("id")

        name = d.pop("name")

        scope = check_scope_word(d.pop("scope"))

        created_at = isoparse(d.pop("created_at"))

        key = d.pop("key")

        def _parse_databases(data: object) -> list[str] | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, list):
                    raise TypeError()
                databases_type_0 = cast(list[str], data)

                return databases_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(list[str] | None | Unset, data)

        databases = _parse_databases(d.pop("databases", UNSET))

        def _parse_requests_per_s(data: object) -> int | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(int | None | Unset, data)

        requests_per_s = _parse_requests_per_s(d.pop("requests_per_s", UNSET))

        def _parse_last_used_at(data: object) -> datetime.datetime | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, str):
                    raise TypeError()
                last_used_at_type_0 = isoparse(data)

                return last_used_at_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(datetime.datetime | None | Unset, data)

        last_used_at = _parse_last_used_at(d.pop("last_used_at", UNSET))

        def _parse_revoked_at(data: object) -> datetime.datetime | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, str):
                    raise TypeError()
                revoked_at_type_0 = isoparse(data)

                return revoked_at_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(datetime.datetime | None | Unset, data)

        revoked_at = _parse_revoked_at(d.pop("revoked_at", UNSET))

        key_made = cls(
            id=id,
            name=name,
            scope=scope,
            created_at=created_at,
            key=key,
            databases=databases,
            requests_per_s=requests_per_s,
            last_used_at=last_used_at,
            revoked_at=revoked_at,
        )

        key_made.additional_properties = d
        return key_made

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
