from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from attrs import define as _attrs_define
from attrs import field as _attrs_field

T = TypeVar("T", bound="ObjectTimingsBody")


@_attrs_define
class ObjectTimingsBody:
    """How long the parts of a recognition took, in milliseconds."""

    appearance: float
    """ The picture as a vector. """
    universal: float
    """ Projection into the universal eigenspace, and the eigenpoints near. """
    object_: float
    """ The likeliest objects' own eigenspaces: which, and how turned. """
    queue: float
    """ Waiting for a computing thread. """
    decode: float
    recognise: float
    """ All that follows decoding. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        appearance = self.appearance

        universal = self.universal

        object_ = self.object_

        queue = self.queue

        decode = self.decode

        recognise = self.recognise

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "appearance": appearance,
                "universal": universal,
                "object": object_,
                "queue": queue,
                "decode": decode,
                "recognise": recognise,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        appearance = d.pop("appearance")

        universal = d.pop("universal")

        object_ = d.pop("object")

        queue = d.pop("queue")

        decode = d.pop("decode")

        recognise = d.pop("recognise")

        object_timings_body = cls(
            appearance=appearance,
            universal=universal,
            object_=object_,
            queue=queue,
            decode=decode,
            recognise=recognise,
        )

        object_timings_body.additional_properties = d
        return object_timings_body

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
