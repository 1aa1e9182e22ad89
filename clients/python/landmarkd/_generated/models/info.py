from __future__ import annotations

import datetime
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field
from dateutil.parser import isoparse

if TYPE_CHECKING:
    from ..models.limits_body import LimitsBody
    from ..models.process_body import ProcessBody


T = TypeVar("T", bound="Info")


@_attrs_define
class Info:
    """What this service is and what it takes."""

    name: str
    version: str
    """ Release. """
    revision: int
    """ Algorithm revision: versions of another revision come from another method. """
    limits: LimitsBody
    """ What is refused. """
    formats: list[str]
    """ Media types of the pictures that are read. """
    started_at: datetime.datetime
    worker: str
    """ The name under which this process does jobs. """
    role: str
    """ Its part of a fleet's work. """
    processes: list[ProcessBody]
    """ The processes that share the catalogue and what each serves, this one first: as they told within the last
    ten seconds. With the catalogue away, this one alone. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        name = self.name

        version = self.version

        revision = self.revision

        limits = self.limits.to_dict()

        formats = self.formats

        started_at = self.started_at.isoformat()

        worker = self.worker

        role = self.role

        processes = []
        for processes_item_data in self.processes:
            processes_item = processes_item_data.to_dict()
            processes.append(processes_item)

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "name": name,
                "version": version,
                "revision": revision,
                "limits": limits,
                "formats": formats,
                "started_at": started_at,
                "worker": worker,
                "role": role,
                "processes": processes,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.limits_body import LimitsBody
        from ..models.process_body import ProcessBody

        d = dict(src_dict)
        name = d.pop("name")

        version = d.pop("version")

        revision = d.pop("revision")

        limits = LimitsBody.from_dict(d.pop("limits"))

        formats = cast(list[str], d.pop("formats"))

        started_at = isoparse(d.pop("started_at"))

        worker = d.pop("worker")

        role = d.pop("role")

        processes = []
        _processes = d.pop("processes")
        for processes_item_data in _processes:
            processes_item = ProcessBody.from_dict(processes_item_data)

            processes.append(processes_item)

        info = cls(
            name=name,
            version=version,
            revision=revision,
            limits=limits,
            formats=formats,
            started_at=started_at,
            worker=worker,
            role=role,
            processes=processes,
        )

        info.additional_properties = d
        return info

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
