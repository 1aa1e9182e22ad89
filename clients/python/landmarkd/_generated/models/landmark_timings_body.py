from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from attrs import define as _attrs_define
from attrs import field as _attrs_field

T = TypeVar("T", bound="LandmarkTimingsBody")


@_attrs_define
class LandmarkTimingsBody:
    """How long the parts of a recognition took, in milliseconds."""

    attention: float
    """ Interest points. """
    signature: float
    """ Sub-windows and their spectra. """
    search: float
    """ Projection and nearest eigenpoints. """
    vote: float
    verification: float
    """ Laying exemplars on the frame. """
    queue: float
    """ Waiting for a computing thread. """
    decode: float
    recognise: float
    """ All that follows decoding. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        attention = self.attention

        signature = self.signature

        search = self.search

        vote = self.vote

        verification = self.verification

        queue = self.queue

        decode = self.decode

        recognise = self.recognise

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "attention": attention,
                "signature": signature,
                "search": search,
                "vote": vote,
                "verification": verification,
                "queue": queue,
                "decode": decode,
                "recognise": recognise,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        attention = d.pop("attention")

        signature = d.pop("signature")

        search = d.pop("search")

        vote = d.pop("vote")

        verification = d.pop("verification")

        queue = d.pop("queue")

        decode = d.pop("decode")

        recognise = d.pop("recognise")

        landmark_timings_body = cls(
            attention=attention,
            signature=signature,
            search=search,
            vote=vote,
            verification=verification,
            queue=queue,
            decode=decode,
            recognise=recognise,
        )

        landmark_timings_body.additional_properties = d
        return landmark_timings_body

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
