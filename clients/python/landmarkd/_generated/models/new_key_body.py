from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, cast

from attrs import define as _attrs_define

from ..models.scope_word import ScopeWord, check_scope_word
from ..types import UNSET, Unset

T = TypeVar("T", bound="NewKeyBody")


@_attrs_define
class NewKeyBody:
    """A key to make."""

    name: str
    """ For people: whose key it is. """
    scope: ScopeWord
    """ What a key may do; each includes the ones before it. """
    databases: list[str] | None | Unset = UNSET
    """ Names of the databases that it reaches, with `*` and `?`; null: every one. """
    requests_per_s: int | None | Unset = UNSET
    """ Most calls a second, to each process; null: as many as there is time for. """

    def to_dict(self) -> dict[str, Any]:
        name = self.name

        scope: str = self.scope

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

        field_dict: dict[str, Any] = {}

        field_dict.update(
            {
                "name": name,
                "scope": scope,
            }
        )
        if databases is not UNSET:
            field_dict["databases"] = databases
        if requests_per_s is not UNSET:
            field_dict["requests_per_s"] = requests_per_s

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        name = d.pop("name")

        scope = check_scope_word(d.pop("scope"))

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

        new_key_body = cls(
            name=name,
            scope=scope,
            databases=databases,
            requests_per_s=requests_per_s,
        )

        return new_key_body
