from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from ..types import UNSET, Unset

if TYPE_CHECKING:
    from ..models.gap_body import GapBody
    from ..models.pose_errors_body import PoseErrorsBody


T = TypeVar("T", bound="OneObjectBody")


@_attrs_define
class OneObjectBody:
    """What is known of one object."""

    label: str
    views: int
    views_with_pose: int
    """ Of these, with a pose. """
    gaps: list[GapBody]
    """ Poses that no view is near: the pose isn't reliable there. """
    threshold: float | None | Unset = UNSET
    """ The largest total distance that is accepted as this object; null if it could not be told. """
    pose: None | PoseErrorsBody | Unset = UNSET
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        from ..models.pose_errors_body import PoseErrorsBody

        label = self.label

        views = self.views

        views_with_pose = self.views_with_pose

        gaps = []
        for gaps_item_data in self.gaps:
            gaps_item = gaps_item_data.to_dict()
            gaps.append(gaps_item)

        threshold: float | None | Unset
        if isinstance(self.threshold, Unset):
            threshold = UNSET
        else:
            threshold = self.threshold

        pose: dict[str, Any] | None | Unset
        if isinstance(self.pose, Unset):
            pose = UNSET
        elif isinstance(self.pose, PoseErrorsBody):
            pose = self.pose.to_dict()
        else:
            pose = self.pose

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "label": label,
                "views": views,
                "views_with_pose": views_with_pose,
                "gaps": gaps,
            }
        )
        if threshold is not UNSET:
            field_dict["threshold"] = threshold
        if pose is not UNSET:
            field_dict["pose"] = pose

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.gap_body import GapBody
        from ..models.pose_errors_body import PoseErrorsBody

        d = dict(src_dict)
        label = d.pop("label")

        views = d.pop("views")

        views_with_pose = d.pop("views_with_pose")

        gaps = []
        _gaps = d.pop("gaps")
        for gaps_item_data in _gaps:
            gaps_item = GapBody.from_dict(gaps_item_data)

            gaps.append(gaps_item)

        def _parse_threshold(data: object) -> float | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(float | None | Unset, data)

        threshold = _parse_threshold(d.pop("threshold", UNSET))

        def _parse_pose(data: object) -> None | PoseErrorsBody | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                pose_type_0 = PoseErrorsBody.from_dict(data)

                return pose_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(None | PoseErrorsBody | Unset, data)

        pose = _parse_pose(d.pop("pose", UNSET))

        one_object_body = cls(
            label=label,
            views=views,
            views_with_pose=views_with_pose,
            gaps=gaps,
            threshold=threshold,
            pose=pose,
        )

        one_object_body.additional_properties = d
        return one_object_body

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
