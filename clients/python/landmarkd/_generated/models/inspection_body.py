from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from ..types import UNSET, Unset

if TYPE_CHECKING:
    from ..models.header_echo import HeaderEcho
    from ..models.inspection_timings import InspectionTimings
    from ..models.part_body import PartBody


T = TypeVar("T", bound="InspectionBody")


@_attrs_define
class InspectionBody:
    """What stands on the table."""

    workcell: str
    database: str
    version: int
    """ The version that answered. """
    digest: str
    header: HeaderEcho
    """ What the robot says about its frame, as an answer echoes it. """
    width_px: int
    height_px: int
    regions_found: int
    """ Regions of at least the least area, also those beyond `max_objects`. """
    objects: list[PartBody]
    """ One for each region, the largest first; also those that are nothing known. """
    warnings: list[str]
    """ `no_region`: nothing stands out. `more_regions`: there are more than `max_objects`. `not_segmented`: the
    version
    was trained without `segment`, so that its pictures were made by another recipe than the parts are cut out by.
    `no_region_in_pair`: nothing stands out in the near-focused picture. Those of a depth map with `depth_` before.
    """
    timings_ms: InspectionTimings
    """ How long the parts of an inspection took, in milliseconds. """
    calibration: None | str | Unset = UNSET
    """ The calibration that distances were measured with; null without a pair. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        workcell = self.workcell

        database = self.database

        version = self.version

        digest = self.digest

        header = self.header.to_dict()

        width_px = self.width_px

        height_px = self.height_px

        regions_found = self.regions_found

        objects = []
        for objects_item_data in self.objects:
            objects_item = objects_item_data.to_dict()
            objects.append(objects_item)

        warnings = self.warnings

        timings_ms = self.timings_ms.to_dict()

        calibration: None | str | Unset
        if isinstance(self.calibration, Unset):
            calibration = UNSET
        else:
            calibration = self.calibration

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "workcell": workcell,
                "database": database,
                "version": version,
                "digest": digest,
                "header": header,
                "width_px": width_px,
                "height_px": height_px,
                "regions_found": regions_found,
                "objects": objects,
                "warnings": warnings,
                "timings_ms": timings_ms,
            }
        )
        if calibration is not UNSET:
            field_dict["calibration"] = calibration

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.header_echo import HeaderEcho
        from ..models.inspection_timings import InspectionTimings
        from ..models.part_body import PartBody

        d = dict(src_dict)
        workcell = d.pop("workcell")

        database = d.pop("database")

        version = d.pop("version")

        digest = d.pop("digest")

        header = HeaderEcho.from_dict(d.pop("header"))

        width_px = d.pop("width_px")

        height_px = d.pop("height_px")

        regions_found = d.pop("regions_found")

        objects = []
        _objects = d.pop("objects")
        for objects_item_data in _objects:
            objects_item = PartBody.from_dict(objects_item_data)

            objects.append(objects_item)

        warnings = cast(list[str], d.pop("warnings"))

        timings_ms = InspectionTimings.from_dict(d.pop("timings_ms"))

        def _parse_calibration(data: object) -> None | str | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(None | str | Unset, data)

        calibration = _parse_calibration(d.pop("calibration", UNSET))

        inspection_body = cls(
            workcell=workcell,
            database=database,
            version=version,
            digest=digest,
            header=header,
            width_px=width_px,
            height_px=height_px,
            regions_found=regions_found,
            objects=objects,
            warnings=warnings,
            timings_ms=timings_ms,
            calibration=calibration,
        )

        inspection_body.additional_properties = d
        return inspection_body

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
