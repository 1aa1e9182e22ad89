from __future__ import annotations

import datetime
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field
from dateutil.parser import isoparse

from ..types import UNSET, Unset

if TYPE_CHECKING:
    from ..models.audit_body_detail import AuditBodyDetail


T = TypeVar("T", bound="AuditBody")


@_attrs_define
class AuditBody:
    """An entry of the record."""

    id: int
    """ Grows with every entry; one of a change that was undone may be missing. """
    at: datetime.datetime
    actor: str
    """ The key's name; without a key `anyone`, `command line`, or `job` and its id. """
    action: str
    detail: AuditBodyDetail
    """ More about it, as the action has it. """
    key: None | str | Unset = UNSET
    """ Id of the key that the call came with. """
    request_id: None | str | Unset = UNSET
    """ `X-Request-Id` of the call. """
    database: None | str | Unset = UNSET
    subject: None | str | Unset = UNSET
    """ What of it: an alias, a version's number, an exemplar's id, a key's id. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        id = self.id

        at = self.at.isoformat()

        actor = self.actor

        action = self.action

        detail = self.detail.to_dict()

        key: None | str | Unset
        if isinstance(self.key, Unset):
            key = UNSET
        else:
            key = self.key

        request_id: None | str | Unset
        if isinstance(self.request_id, Unset):
            request_id = UNSET
        else:
            request_id = self.request_id

        database: None | str | Unset
        if isinstance(self.database, Unset):
            database = UNSET
        else:
            database = self.database

        subject: None | str | Unset
        if isinstance(self.subject, Unset):
            subject = UNSET
        else:
            subject = self.subject

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "id": id,
                "at": at,
                "actor": actor,
                "action": action,
                "detail": detail,
            }
        )
        if key is not UNSET:
            field_dict["key"] = key
        if request_id is not UNSET:
            field_dict["request_id"] = request_id
        if database is not UNSET:
            field_dict["database"] = database
        if subject is not UNSET:
            field_dict["subject"] = subject

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.audit_body_detail import AuditBodyDetail

        d = dict(src_dict)
        id = d.pop("id")

        at = isoparse(d.pop("at"))

        actor = d.pop("actor")

        action = d.pop("action")

        detail = AuditBodyDetail.from_dict(d.pop("detail"))

        def _parse_key(data: object) -> None | str | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(None | str | Unset, data)

        key = _parse_key(d.pop("key", UNSET))

        def _parse_request_id(data: object) -> None | str | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(None | str | Unset, data)

        request_id = _parse_request_id(d.pop("request_id", UNSET))

        def _parse_database(data: object) -> None | str | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(None | str | Unset, data)

        database = _parse_database(d.pop("database", UNSET))

        def _parse_subject(data: object) -> None | str | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(None | str | Unset, data)

        subject = _parse_subject(d.pop("subject", UNSET))

        audit_body = cls(
            id=id,
            at=at,
            actor=actor,
            action=action,
            detail=detail,
            key=key,
            request_id=request_id,
            database=database,
            subject=subject,
        )

        audit_body.additional_properties = d
        return audit_body

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
