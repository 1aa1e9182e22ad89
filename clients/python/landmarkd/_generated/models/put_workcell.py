from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

from attrs import define as _attrs_define

from ..models.mapping_kind_word import MappingKindWord, check_mapping_kind_word
from ..types import UNSET, Unset

if TYPE_CHECKING:
    from ..models.correspondence_body import CorrespondenceBody
    from ..models.local_camera_body import LocalCameraBody
    from ..models.segmentation_options_body import SegmentationOptionsBody


T = TypeVar("T", bound="PutWorkcell")


@_attrs_define
class PutWorkcell:
    """What is known of a workcell."""

    database: str
    """ The database that names the parts, of kind `objects`. """
    correspondences: list[CorrespondenceBody]
    """ What the mapping is fitted to: two at the least for a similarity, three for an affine map, four for a
    homography; more even out their errors. """
    calibration: None | str | Unset = UNSET
    """ The rig that measures distances, for inspections with a focal pair. """
    mapping: MappingKindWord | None | Unset = UNSET
    flip_y: bool | None | Unset = True
    """ Whether the robot's Y grows where the image's y falls, as seen by both cameras. """
    local: LocalCameraBody | None | Unset = UNSET
    tolerance_px: float | None | Unset = 1.0
    """ A part counts as centred within so many pixels. """
    segmentation: None | SegmentationOptionsBody | Unset = UNSET

    def to_dict(self) -> dict[str, Any]:
        from ..models.local_camera_body import LocalCameraBody
        from ..models.segmentation_options_body import SegmentationOptionsBody

        database = self.database

        correspondences = []
        for correspondences_item_data in self.correspondences:
            correspondences_item = correspondences_item_data.to_dict()
            correspondences.append(correspondences_item)

        calibration: None | str | Unset
        if isinstance(self.calibration, Unset):
            calibration = UNSET
        else:
            calibration = self.calibration

        mapping: None | str | Unset
        if isinstance(self.mapping, Unset):
            mapping = UNSET
        elif isinstance(self.mapping, str):
            mapping = self.mapping
        else:
            mapping = self.mapping

        flip_y: bool | None | Unset
        if isinstance(self.flip_y, Unset):
            flip_y = UNSET
        else:
            flip_y = self.flip_y

        local: dict[str, Any] | None | Unset
        if isinstance(self.local, Unset):
            local = UNSET
        elif isinstance(self.local, LocalCameraBody):
            local = self.local.to_dict()
        else:
            local = self.local

        tolerance_px: float | None | Unset
        if isinstance(self.tolerance_px, Unset):
            tolerance_px = UNSET
        else:
            tolerance_px = self.tolerance_px

        segmentation: dict[str, Any] | None | Unset
        if isinstance(self.segmentation, Unset):
            segmentation = UNSET
        elif isinstance(self.segmentation, SegmentationOptionsBody):
            segmentation = self.segmentation.to_dict()
        else:
            segmentation = self.segmentation

        field_dict: dict[str, Any] = {}

        field_dict.update(
            {
                "database": database,
                "correspondences": correspondences,
            }
        )
        if calibration is not UNSET:
            field_dict["calibration"] = calibration
        if mapping is not UNSET:
            field_dict["mapping"] = mapping
        if flip_y is not UNSET:
            field_dict["flip_y"] = flip_y
        if local is not UNSET:
            field_dict["local"] = local
        if tolerance_px is not UNSET:
            field_dict["tolerance_px"] = tolerance_px
        if segmentation is not UNSET:
            field_dict["segmentation"] = segmentation

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.correspondence_body import CorrespondenceBody
        from ..models.local_camera_body import LocalCameraBody
        from ..models.segmentation_options_body import SegmentationOptionsBody

        d = dict(src_dict)
        database = d.pop("database")

        correspondences = []
        _correspondences = d.pop("correspondences")
        for correspondences_item_data in _correspondences:
            correspondences_item = CorrespondenceBody.from_dict(correspondences_item_data)

            correspondences.append(correspondences_item)

        def _parse_calibration(data: object) -> None | str | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(None | str | Unset, data)

        calibration = _parse_calibration(d.pop("calibration", UNSET))

        def _parse_mapping(data: object) -> MappingKindWord | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, str):
                    raise TypeError()
                mapping_type_0 = check_mapping_kind_word(data)

                return mapping_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(MappingKindWord | None | Unset, data)

        mapping = _parse_mapping(d.pop("mapping", UNSET))

        def _parse_flip_y(data: object) -> bool | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(bool | None | Unset, data)

        flip_y = _parse_flip_y(d.pop("flip_y", UNSET))

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

        def _parse_tolerance_px(data: object) -> float | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(float | None | Unset, data)

        tolerance_px = _parse_tolerance_px(d.pop("tolerance_px", UNSET))

        def _parse_segmentation(data: object) -> None | SegmentationOptionsBody | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                segmentation_type_0 = SegmentationOptionsBody.from_dict(data)

                return segmentation_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(None | SegmentationOptionsBody | Unset, data)

        segmentation = _parse_segmentation(d.pop("segmentation", UNSET))

        put_workcell = cls(
            database=database,
            correspondences=correspondences,
            calibration=calibration,
            mapping=mapping,
            flip_y=flip_y,
            local=local,
            tolerance_px=tolerance_px,
            segmentation=segmentation,
        )

        return put_workcell
