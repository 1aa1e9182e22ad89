from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from ..types import UNSET, Unset

if TYPE_CHECKING:
    from ..models.decision_body import DecisionBody
    from ..models.label_belief_body import LabelBeliefBody


T = TypeVar("T", bound="BeliefBody")


@_attrs_define
class BeliefBody:
    """Where a robot is, by all its frames so far."""

    belief: list[LabelBeliefBody]
    """ The likeliest labels, best first. """
    elsewhere: float
    """ Probability of being where no exemplar was taken. """
    decision: DecisionBody | None | Unset = UNSET
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        from ..models.decision_body import DecisionBody

        belief = []
        for belief_item_data in self.belief:
            belief_item = belief_item_data.to_dict()
            belief.append(belief_item)

        elsewhere = self.elsewhere

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
                "belief": belief,
                "elsewhere": elsewhere,
            }
        )
        if decision is not UNSET:
            field_dict["decision"] = decision

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.decision_body import DecisionBody
        from ..models.label_belief_body import LabelBeliefBody

        d = dict(src_dict)
        belief = []
        _belief = d.pop("belief")
        for belief_item_data in _belief:
            belief_item = LabelBeliefBody.from_dict(belief_item_data)

            belief.append(belief_item)

        elsewhere = d.pop("elsewhere")

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

        belief_body = cls(
            belief=belief,
            elsewhere=elsewhere,
            decision=decision,
        )

        belief_body.additional_properties = d
        return belief_body

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
