from __future__ import annotations

import datetime
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast
from uuid import UUID

from attrs import define as _attrs_define
from attrs import field as _attrs_field
from dateutil.parser import isoparse

from ..models.motion_word import MotionWord, check_motion_word
from ..types import UNSET, Unset

if TYPE_CHECKING:
    from ..models.decision_body import DecisionBody
    from ..models.label_belief_body import LabelBeliefBody


T = TypeVar("T", bound="TrackDetail")


@_attrs_define
class TrackDetail:
    """A track with what is believed."""

    id: UUID
    database: str
    alias: str
    """ The alias whose version answers. """
    motion: MotionWord
    """ How robots move among the exemplars. """
    version: int
    """ The version that answered last. """
    frames: int
    """ Frames that were counted. """
    warnings: list[str]
    """ `order_unknown`: `path` was asked for, but the version has exemplars that came with an artifact file or were
    deleted from the database, so that their order isn't known. """
    created_at: datetime.datetime
    expires_at: datetime.datetime
    """ When it is gone unless another frame comes. """
    belief: list[LabelBeliefBody]
    """ The likeliest labels, best first. """
    elsewhere: float
    """ Probability of being where no exemplar was taken. """
    decision: DecisionBody | None | Unset = UNSET
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        from ..models.decision_body import DecisionBody

        id = str(self.id)

        database = self.database

        alias = self.alias

        motion: str = self.motion

        version = self.version

        frames = self.frames

        warnings = self.warnings

        created_at = self.created_at.isoformat()

        expires_at = self.expires_at.isoformat()

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
                "id": id,
                "database": database,
                "alias": alias,
                "motion": motion,
                "version": version,
                "frames": frames,
                "warnings": warnings,
                "created_at": created_at,
                "expires_at": expires_at,
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
        id = UUID(d.pop("id"))

        database = d.pop("database")

        alias = d.pop("alias")

        motion = check_motion_word(d.pop("motion"))

        version = d.pop("version")

        frames = d.pop("frames")

        warnings = cast(list[str], d.pop("warnings"))

        created_at = isoparse(d.pop("created_at"))

        expires_at = isoparse(d.pop("expires_at"))

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

        track_detail = cls(
            id=id,
            database=database,
            alias=alias,
            motion=motion,
            version=version,
            frames=frames,
            warnings=warnings,
            created_at=created_at,
            expires_at=expires_at,
            belief=belief,
            elsewhere=elsewhere,
            decision=decision,
        )

        track_detail.additional_properties = d
        return track_detail

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
