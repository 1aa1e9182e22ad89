from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

if TYPE_CHECKING:
    from ..models.header_echo import HeaderEcho
    from ..models.region_body import RegionBody
    from ..models.segmentation_timings import SegmentationTimings


T = TypeVar("T", bound="SegmentationBody")


@_attrs_define
class SegmentationBody:
    """What stands out from the background."""

    header: HeaderEcho
    """ What the robot says about its frame, as an answer echoes it. """
    width_px: int
    height_px: int
    regions_found: int
    """ Regions of at least the least area, also those beyond `max_objects`. """
    regions: list[RegionBody]
    """ The largest first. """
    warnings: list[str]
    """ `no_region`: nothing stands out. `more_regions`: there are more than `max_objects`. """
    timings_ms: SegmentationTimings
    """ How long the parts of a segmentation took, in milliseconds. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        header = self.header.to_dict()

        width_px = self.width_px

        height_px = self.height_px

        regions_found = self.regions_found

        regions = []
        for regions_item_data in self.regions:
            regions_item = regions_item_data.to_dict()
            regions.append(regions_item)

        warnings = self.warnings

        timings_ms = self.timings_ms.to_dict()

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "header": header,
                "width_px": width_px,
                "height_px": height_px,
                "regions_found": regions_found,
                "regions": regions,
                "warnings": warnings,
                "timings_ms": timings_ms,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.header_echo import HeaderEcho
        from ..models.region_body import RegionBody
        from ..models.segmentation_timings import SegmentationTimings

        d = dict(src_dict)
        header = HeaderEcho.from_dict(d.pop("header"))

        width_px = d.pop("width_px")

        height_px = d.pop("height_px")

        regions_found = d.pop("regions_found")

        regions = []
        _regions = d.pop("regions")
        for regions_item_data in _regions:
            regions_item = RegionBody.from_dict(regions_item_data)

            regions.append(regions_item)

        warnings = cast(list[str], d.pop("warnings"))

        timings_ms = SegmentationTimings.from_dict(d.pop("timings_ms"))

        segmentation_body = cls(
            header=header,
            width_px=width_px,
            height_px=height_px,
            regions_found=regions_found,
            regions=regions,
            warnings=warnings,
            timings_ms=timings_ms,
        )

        segmentation_body.additional_properties = d
        return segmentation_body

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
