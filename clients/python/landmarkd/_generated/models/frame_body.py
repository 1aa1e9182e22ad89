from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from ..types import UNSET, Unset

if TYPE_CHECKING:
    from ..models.decision_body import DecisionBody


T = TypeVar("T", bound="FrameBody")


@_attrs_define
class FrameBody:
    """A frame of a track."""

    number: int
    """ Its number in the track, from 1. """
    counted: bool
    """ False when it was the last frame sent again (the same `X-Frame-Id`, header and picture): the belief is as it
    was. """
    decision: DecisionBody | None | Unset = UNSET
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        from ..models.decision_body import DecisionBody

        number = self.number

        counted = self.counted

        decision: dict[str, Any] | None | Unset
        if isinstance(self.decision, Unset):
            decision = UNSET
        elif isinstance(self.decision, DecisionBody):
            decision = self.decision.to_dict()
        else:
            decision = self.decision

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "number": number,
                "counted": counted,
            }
        )
        if decision is not UNSET:
            field_dict["decision"] = decision

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.decision_body import DecisionBody

        d = dict(src_dict)
        number = d.pop("number")

        counted = d.pop("counted")

        def _parse_decision(data: object) -> DecisionBody | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                decision_type_0 = DecisionBody.from_dict(data)

                return decision_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(DecisionBody | None | Unset, data)

        decision = _parse_decision(d.pop("decision", UNSET))

        frame_body = cls(
            number=number,
            counted=counted,
            decision=decision,
        )

        frame_body.additional_properties = d
        return frame_body

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
