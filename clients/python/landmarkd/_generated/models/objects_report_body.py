from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from ..types import UNSET, Unset

if TYPE_CHECKING:
    from ..models.confusion_body import ConfusionBody
    from ..models.dimension_rate_body import DimensionRateBody
    from ..models.held_out_body import HeldOutBody
    from ..models.one_object_body import OneObjectBody
    from ..models.training_timings import TrainingTimings


T = TypeVar("T", bound="ObjectsReportBody")


@_attrs_define
class ObjectsReportBody:
    """What the training of an object database told of itself. Rates are of views that were left out."""

    spectrum: list[float]
    """ Variance along the directions of the universal eigenspace, descending; for more than 1500 views the leading
    ones. """
    energy_kept: float
    """ Part of the variance that the kept dimensions hold. """
    dimension: int
    """ Dimensions kept. """
    width_px: int
    """ Width of the database's pictures. """
    height_px: int
    """ Height of the database's pictures. """
    vector_length: int
    """ Components of an appearance. """
    rate_by_dimension: list[DimensionRateBody]
    """ Left-out views whose nearest eigenpoint is of their own object, by dimension. """
    confusion: list[ConfusionBody]
    """ Left-out views that were taken for another object, or for none. """
    objects: list[OneObjectBody]
    """ By object. """
    near_duplicates: list[list[str]]
    """ Pairs of exemplars that are all but the same picture. """
    repeated_poses: list[list[str]]
    """ Pairs of exemplars of one object with one pose: their mean is taken. """
    over_exposed: list[str]
    """ Exemplars with too many pixels as bright as can be. """
    under_exposed: list[str]
    """ Exemplars with hardly a bright pixel. """
    blank: list[str]
    """ Exemplars that are black, or in which nothing stands out to be cut out: they were left out. """
    resized: list[str]
    """ Exemplars that were not of the database's size, and were scaled. """
    touches_border: list[str]
    """ With `segment`: exemplars whose object reaches the picture's border, which may cut it. """
    several_regions: list[str]
    """ With `segment`: exemplars in which another thing is nearly as large; the largest was learnt. """
    held_out: HeldOutBody | None | Unset = UNSET
    timings_ms: None | TrainingTimings | Unset = UNSET
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        from ..models.held_out_body import HeldOutBody
        from ..models.training_timings import TrainingTimings

        spectrum = self.spectrum

        energy_kept = self.energy_kept

        dimension = self.dimension

        width_px = self.width_px

        height_px = self.height_px

        vector_length = self.vector_length

        rate_by_dimension = []
        for rate_by_dimension_item_data in self.rate_by_dimension:
            rate_by_dimension_item = rate_by_dimension_item_data.to_dict()
            rate_by_dimension.append(rate_by_dimension_item)

        confusion = []
        for confusion_item_data in self.confusion:
            confusion_item = confusion_item_data.to_dict()
            confusion.append(confusion_item)

        objects = []
        for objects_item_data in self.objects:
            objects_item = objects_item_data.to_dict()
            objects.append(objects_item)

        near_duplicates = []
        for near_duplicates_item_data in self.near_duplicates:
            near_duplicates_item = near_duplicates_item_data

            near_duplicates.append(near_duplicates_item)

        repeated_poses = []
        for repeated_poses_item_data in self.repeated_poses:
            repeated_poses_item = repeated_poses_item_data

            repeated_poses.append(repeated_poses_item)

        over_exposed = self.over_exposed

        under_exposed = self.under_exposed

        blank = self.blank

        resized = self.resized

        touches_border = self.touches_border

        several_regions = self.several_regions

        held_out: dict[str, Any] | None | Unset
        if isinstance(self.held_out, Unset):
            held_out = UNSET
        elif isinstance(self.held_out, HeldOutBody):
            held_out = self.held_out.to_dict()
        else:
            held_out = self.held_out

        timings_ms: dict[str, Any] | None | Unset
        if isinstance(self.timings_ms, Unset):
            timings_ms = UNSET
        elif isinstance(self.timings_ms, TrainingTimings):
            timings_ms = self.timings_ms.to_dict()
        else:
            timings_ms = self.timings_ms

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "spectrum": spectrum,
                "energy_kept": energy_kept,
                "dimension": dimension,
                "width_px": width_px,
                "height_px": height_px,
                "vector_length": vector_length,
                "rate_by_dimension": rate_by_dimension,
                "confusion": confusion,
                "objects": objects,
                "near_duplicates": near_duplicates,
                "repeated_poses": repeated_poses,
                "over_exposed": over_exposed,
                "under_exposed": under_exposed,
                "blank": blank,
                "resized": resized,
                "touches_border": touches_border,
                "several_regions": several_regions,
            }
        )
        if held_out is not UNSET:
            field_dict["held_out"] = held_out
        if timings_ms is not UNSET:
            field_dict["timings_ms"] = timings_ms

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.confusion_body import ConfusionBody
        from ..models.dimension_rate_body import DimensionRateBody
        from ..models.held_out_body import HeldOutBody
        from ..models.one_object_body import OneObjectBody
        from ..models.training_timings import TrainingTimings

        d = dict(src_dict)
        spectrum = cast(list[float], d.pop("spectrum"))

        energy_kept = d.pop("energy_kept")

        dimension = d.pop("dimension")

        width_px = d.pop("width_px")

        height_px = d.pop("height_px")

        vector_length = d.pop("vector_length")

        rate_by_dimension = []
        _rate_by_dimension = d.pop("rate_by_dimension")
        for rate_by_dimension_item_data in _rate_by_dimension:
            rate_by_dimension_item = DimensionRateBody.from_dict(rate_by_dimension_item_data)

            rate_by_dimension.append(rate_by_dimension_item)

        confusion = []
        _confusion = d.pop("confusion")
        for confusion_item_data in _confusion:
            confusion_item = ConfusionBody.from_dict(confusion_item_data)

            confusion.append(confusion_item)

        objects = []
        _objects = d.pop("objects")
        for objects_item_data in _objects:
            objects_item = OneObjectBody.from_dict(objects_item_data)

            objects.append(objects_item)

        near_duplicates = []
        _near_duplicates = d.pop("near_duplicates")
        for near_duplicates_item_data in _near_duplicates:
            near_duplicates_item = cast(list[str], near_duplicates_item_data)

            near_duplicates.append(near_duplicates_item)

        repeated_poses = []
        _repeated_poses = d.pop("repeated_poses")
        for repeated_poses_item_data in _repeated_poses:
            repeated_poses_item = cast(list[str], repeated_poses_item_data)

            repeated_poses.append(repeated_poses_item)

        over_exposed = cast(list[str], d.pop("over_exposed"))

        under_exposed = cast(list[str], d.pop("under_exposed"))

        blank = cast(list[str], d.pop("blank"))

        resized = cast(list[str], d.pop("resized"))

        touches_border = cast(list[str], d.pop("touches_border"))

        several_regions = cast(list[str], d.pop("several_regions"))

        def _parse_held_out(data: object) -> HeldOutBody | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                held_out_type_0 = HeldOutBody.from_dict(data)

                return held_out_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(HeldOutBody | None | Unset, data)

        held_out = _parse_held_out(d.pop("held_out", UNSET))

        def _parse_timings_ms(data: object) -> None | TrainingTimings | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                timings_ms_type_0 = TrainingTimings.from_dict(data)

                return timings_ms_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(None | TrainingTimings | Unset, data)

        timings_ms = _parse_timings_ms(d.pop("timings_ms", UNSET))

        objects_report_body = cls(
            spectrum=spectrum,
            energy_kept=energy_kept,
            dimension=dimension,
            width_px=width_px,
            height_px=height_px,
            vector_length=vector_length,
            rate_by_dimension=rate_by_dimension,
            confusion=confusion,
            objects=objects,
            near_duplicates=near_duplicates,
            repeated_poses=repeated_poses,
            over_exposed=over_exposed,
            under_exposed=under_exposed,
            blank=blank,
            resized=resized,
            touches_border=touches_border,
            several_regions=several_regions,
            held_out=held_out,
            timings_ms=timings_ms,
        )

        objects_report_body.additional_properties = d
        return objects_report_body

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
