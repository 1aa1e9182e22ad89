from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from ..types import UNSET, Unset

if TYPE_CHECKING:
    from ..models.instance_body import InstanceBody
    from ..models.point_body import PointBody
    from ..models.vote_body import VoteBody


T = TypeVar("T", bound="LandmarkEvidence")


@_attrs_define
class LandmarkEvidence:
    """What speaks for the answer of a landmark database."""

    votes: list[VoteBody]
    """ The evidence, best first. """
    instances: list[InstanceBody]
    """ Everything known that is in the frame for sure enough, surest first: several things, or one several times.
    Empty
    where answers have no confidence, or no placement. """
    points_used: int
    """ Interest points that were asked: no more than it takes. """
    points_found: int
    """ Interest points in the frame. """
    points: list[PointBody] | None | Unset = UNSET
    """ With `explain`: every point's vote, most salient first. For each label the weights sum to its W. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        votes = []
        for votes_item_data in self.votes:
            votes_item = votes_item_data.to_dict()
            votes.append(votes_item)

        instances = []
        for instances_item_data in self.instances:
            instances_item = instances_item_data.to_dict()
            instances.append(instances_item)

        points_used = self.points_used

        points_found = self.points_found

        points: list[dict[str, Any]] | None | Unset
        if isinstance(self.points, Unset):
            points = UNSET
        elif isinstance(self.points, list):
            points = []
            for points_type_0_item_data in self.points:
                points_type_0_item = points_type_0_item_data.to_dict()
                points.append(points_type_0_item)

        else:
            points = self.points

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "votes": votes,
                "instances": instances,
                "points_used": points_used,
                "points_found": points_found,
            }
        )
        if points is not UNSET:
            field_dict["points"] = points

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.instance_body import InstanceBody
        from ..models.point_body import PointBody
        from ..models.vote_body import VoteBody

        d = dict(src_dict)
        votes = []
        _votes = d.pop("votes")
        for votes_item_data in _votes:
            votes_item = VoteBody.from_dict(votes_item_data)

            votes.append(votes_item)

        instances = []
        _instances = d.pop("instances")
        for instances_item_data in _instances:
            instances_item = InstanceBody.from_dict(instances_item_data)

            instances.append(instances_item)

        points_used = d.pop("points_used")

        points_found = d.pop("points_found")

        def _parse_points(data: object) -> list[PointBody] | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, list):
                    raise TypeError()
                points_type_0 = []
                _points_type_0 = data
                for points_type_0_item_data in _points_type_0:
                    points_type_0_item = PointBody.from_dict(points_type_0_item_data)

                    points_type_0.append(points_type_0_item)

                return points_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(list[PointBody] | None | Unset, data)

        points = _parse_points(d.pop("points", UNSET))

        landmark_evidence = cls(
            votes=votes,
            instances=instances,
            points_used=points_used,
            points_found=points_found,
            points=points,
        )

        landmark_evidence.additional_properties = d
        return landmark_evidence

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
