from __future__ import annotations

import datetime
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field
from dateutil.parser import isoparse

from ..types import UNSET, Unset

if TYPE_CHECKING:
    from ..models.correspondence_body import CorrespondenceBody
    from ..models.local_camera_body import LocalCameraBody
    from ..models.mapping_body import MappingBody
    from ..models.segmentation_options_body import SegmentationOptionsBody


T = TypeVar("T", bound="WorkcellBody")


@_attrs_define
class WorkcellBody:
    """A workcell as it is kept."""

    name: str
    database: str
    correspondences: list[CorrespondenceBody]
    flip_y: bool
    mapping: MappingBody
    """ From the overview camera's pixels to the robot. """
    tolerance_px: float
    segmentation: SegmentationOptionsBody
    """ Options of a segmentation. What is absent has its default. """
    warnings: list[str]
    """ `mirrored`: with the other `flip_y` the correspondences would fit far better, or two of them were exchanged.
    """
    created_at: datetime.datetime
    updated_at: datetime.datetime
    calibration: None | str | Unset = UNSET
    local: LocalCameraBody | None | Unset = UNSET
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        from ..models.local_camera_body import LocalCameraBody

        name = self.name

        database = self.database

        correspondences = []
        for correspondences_item_data in self.correspondences:
            correspondences_item = correspondences_item_data.to_dict()
            correspondences.append(correspondences_item)

        flip_y = self.flip_y

        mapping = self.mapping.to_dict()

        tolerance_px = self.tolerance_px

        segmentation = self.segmentation.to_dict()

        warnings = self.warnings

        created_at = self.created_at.isoformat()

        updated_at = self.updated_at.isoformat()

        calibration: None | str | Unset
        if isinstance(self.calibration, Unset):
            calibration = UNSET
        else:
            calibration = self.calibration

        local: dict[str, Any] | None | Unset
        if isinstance(self.local, Unset):
            local = UNSET
        elif isinstance(self.local, LocalCameraBody):
            local = self.local.to_dict()
        else:
            local = self.local

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "name": name,
                "database": database,
                "correspondences": correspondences,
                "flip_y": flip_y,
                "mapping": mapping,
                "tolerance_px": tolerance_px,
                "segmentation": segmentation,
                "warnings": warnings,
                "created_at": created_at,
                "updated_at": updated_at,
            }
        )
        if calibration is not UNSET:
            field_dict["calibration"] = calibration
        if local is not UNSET:
            field_dict["local"] = local

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.correspondence_body import CorrespondenceBody
        from ..models.local_camera_body import LocalCameraBody
        from ..models.mapping_body import MappingBody
        from ..models.segmentation_options_body import SegmentationOptionsBody

        d = dict(src_dict)
        name = d.pop("name")

        database = d.pop("database")

        correspondences = []
        _correspondences = d.pop("correspondences")
        for correspondences_item_data in _correspondences:
            correspondences_item = CorrespondenceBody.from_dict(correspondences_item_data)

            correspondences.append(correspondences_item)

        flip_y = d.pop("flip_y")

        mapping = MappingBody.from_dict(d.pop("mapping"))

        tolerance_px = d.pop("tolerance_px")

        segmentation = SegmentationOptionsBody.from_dict(d.pop("segmentation"))

        warnings = cast(list[str], d.pop("warnings"))

        created_at = isoparse(d.pop("created_at"))

        updated_at = isoparse(d.pop("updated_at"))

        def _parse_calibration(data: object) -> None | str | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(None | str | Unset, data)

        calibration = _parse_calibration(d.pop("calibration", UNSET))

        def _parse_local(data: object) -> LocalCameraBody | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                local_type_0 = LocalCameraBody.from_dict(data)

                return local_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(LocalCameraBody | None | Unset, data)

        local = _parse_local(d.pop("local", UNSET))

        workcell_body = cls(
            name=name,
            database=database,
            correspondences=correspondences,
            flip_y=flip_y,
            mapping=mapping,
            tolerance_px=tolerance_px,
            segmentation=segmentation,
            warnings=warnings,
            created_at=created_at,
            updated_at=updated_at,
            calibration=calibration,
            local=local,
        )

        workcell_body.additional_properties = d
        return workcell_body

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
