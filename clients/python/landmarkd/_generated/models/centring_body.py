from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from ..types import UNSET, Unset

if TYPE_CHECKING:
    from ..models.header_echo import HeaderEcho
    from ..models.region_body import RegionBody
    from ..models.segmentation_timings import SegmentationTimings


T = TypeVar("T", bound="CentringBody")


@_attrs_define
class CentringBody:
    """By how much the part nearest the picture's middle is off it."""

    workcell: str
    header: HeaderEcho
    """ What the robot says about its frame, as an answer echoes it. """
    region: RegionBody
    """ A connected part of a picture that stands out from its background. """
    move_px: list[float]
    """ Its centroid less the picture's middle, x and y. """
    centred: bool
    """ Whether it is within the workcell's tolerance. """
    distance_px: float
    """ How far it is off the middle. """
    timings_ms: SegmentationTimings
    """ How long the parts of a segmentation took, in milliseconds. """
    move_mm: list[float] | None | Unset = UNSET
    """ By how much the gripper must move to have it in the middle, X and Y; null while the workcell says nothing of
    the
    local camera. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        workcell = self.workcell

        header = self.header.to_dict()

        region = self.region.to_dict()

        move_px = self.move_px

        centred = self.centred

        distance_px = self.distance_px

        timings_ms = self.timings_ms.to_dict()

        move_mm: list[float] | None | Unset
        if isinstance(self.move_mm, Unset):
            move_mm = UNSET
        elif isinstance(self.move_mm, list):
            move_mm = self.move_mm

        else:
            move_mm = self.move_mm

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "workcell": workcell,
                "header": header,
                "region": region,
                "move_px": move_px,
                "centred": centred,
                "distance_px": distance_px,
                "timings_ms": timings_ms,
            }
        )
        if move_mm is not UNSET:
            field_dict["move_mm"] = move_mm

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.header_echo import HeaderEcho
        from ..models.region_body import RegionBody
        from ..models.segmentation_timings import SegmentationTimings

        d = dict(src_dict)
        workcell = d.pop("workcell")

        header = HeaderEcho.from_dict(d.pop("header"))

        region = RegionBody.from_dict(d.pop("region"))

        move_px = cast(list[float], d.pop("move_px"))

        centred = d.pop("centred")

        distance_px = d.pop("distance_px")

        timings_ms = SegmentationTimings.from_dict(d.pop("timings_ms"))

        def _parse_move_mm(data: object) -> list[float] | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, list):
                    raise TypeError()
                move_mm_type_0 = cast(list[float], data)

                return move_mm_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(list[float] | None | Unset, data)

        move_mm = _parse_move_mm(d.pop("move_mm", UNSET))

        centring_body = cls(
            workcell=workcell,
            header=header,
            region=region,
            move_px=move_px,
            centred=centred,
            distance_px=distance_px,
            timings_ms=timings_ms,
            move_mm=move_mm,
        )

        centring_body.additional_properties = d
        return centring_body

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
