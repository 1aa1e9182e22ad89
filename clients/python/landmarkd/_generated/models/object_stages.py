from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from attrs import define as _attrs_define
from attrs import field as _attrs_field

T = TypeVar("T", bound="ObjectStages")


@_attrs_define
class ObjectStages:
    """The parts of a recognition by whole appearance, in milliseconds."""

    appearance: float
    """ The picture as a vector. """
    universal: float
    """ Projection into the universal eigenspace, and the eigenpoints near. """
    object_: float
    """ The likeliest objects' own eigenspaces: which, and how turned. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        appearance = self.appearance

        universal = self.universal

        object_ = self.object_

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "appearance": appearance,
                "universal": universal,
                "object": object_,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        appearance = d.pop("appearance")

        universal = d.pop("universal")

        object_ = d.pop("object")

        object_stages = cls(
            appearance=appearance,
            universal=universal,
            object_=object_,
        )

        object_stages.additional_properties = d
        return object_stages

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
