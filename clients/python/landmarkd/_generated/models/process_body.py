from __future__ import annotations

import datetime
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from attrs import define as _attrs_define
from attrs import field as _attrs_field
from dateutil.parser import isoparse

if TYPE_CHECKING:
    from ..models.database_ready import DatabaseReady


T = TypeVar("T", bound="ProcessBody")


@_attrs_define
class ProcessBody:
    """A process, and what it serves."""

    worker: str
    role: str
    started_at: datetime.datetime
    databases: list[DatabaseReady]
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        worker = self.worker

        role = self.role

        started_at = self.started_at.isoformat()

        databases = []
        for databases_item_data in self.databases:
            databases_item = databases_item_data.to_dict()
            databases.append(databases_item)

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "worker": worker,
                "role": role,
                "started_at": started_at,
                "databases": databases,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.database_ready import DatabaseReady

        d = dict(src_dict)
        worker = d.pop("worker")

        role = d.pop("role")

        started_at = isoparse(d.pop("started_at"))

        databases = []
        _databases = d.pop("databases")
        for databases_item_data in _databases:
            databases_item = DatabaseReady.from_dict(databases_item_data)

            databases.append(databases_item)

        process_body = cls(
            worker=worker,
            role=role,
            started_at=started_at,
            databases=databases,
        )

        process_body.additional_properties = d
        return process_body

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
