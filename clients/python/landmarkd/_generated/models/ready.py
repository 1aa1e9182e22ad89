from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from ..models.ready_status import ReadyStatus, check_ready_status
from ..models.store_status import StoreStatus, check_store_status

if TYPE_CHECKING:
    from ..models.database_ready import DatabaseReady


T = TypeVar("T", bound="Ready")


@_attrs_define
class Ready:
    """Whether the service answers, and with what."""

    status: ReadyStatus
    """ `degraded` still answers: something is broken, the rest serves. """
    databases: list[DatabaseReady]
    catalogue: StoreStatus
    """ A store as this process sees it. """
    blobs: StoreStatus
    """ A store as this process sees it. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        status: str = self.status

        databases = []
        for databases_item_data in self.databases:
            databases_item = databases_item_data.to_dict()
            databases.append(databases_item)

        catalogue: str = self.catalogue

        blobs: str = self.blobs

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "status": status,
                "databases": databases,
                "catalogue": catalogue,
                "blobs": blobs,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.database_ready import DatabaseReady

        d = dict(src_dict)
        status = check_ready_status(d.pop("status"))

        databases = []
        _databases = d.pop("databases")
        for databases_item_data in _databases:
            databases_item = DatabaseReady.from_dict(databases_item_data)

            databases.append(databases_item)

        catalogue = check_store_status(d.pop("catalogue"))

        blobs = check_store_status(d.pop("blobs"))

        ready = cls(
            status=status,
            databases=databases,
            catalogue=catalogue,
            blobs=blobs,
        )

        ready.additional_properties = d
        return ready

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
