from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, cast

from attrs import define as _attrs_define

from ..models.polarity_word import PolarityWord, check_polarity_word
from ..models.threshold_word import ThresholdWord, check_threshold_word
from ..types import UNSET, Unset

T = TypeVar("T", bound="SegmentationOptionsBody")


@_attrs_define
class SegmentationOptionsBody:
    """Options of a segmentation. What is absent has its default."""

    threshold: float | None | ThresholdWord | Unset = UNSET
    window_px: int | None | Unset = UNSET
    """ Adaptive only: side of the square that the background is looked for in; null or absent: chosen from the
    picture. """
    offset: float | None | Unset = UNSET
    """ Adaptive only: how far a pixel must stand out from the background, in grey levels; null or absent: chosen
    from
    the picture. """
    polarity: None | PolarityWord | Unset = UNSET
    min_area_px: int | None | Unset = UNSET
    """ Smaller regions are specks; null or absent: chosen from the picture. """
    max_objects: int | None | Unset = 100
    """ Most regions that are told of, the largest. """

    def to_dict(self) -> dict[str, Any]:
        threshold: float | None | str | Unset
        if isinstance(self.threshold, Unset):
            threshold = UNSET
        elif isinstance(self.threshold, str):
            threshold = self.threshold
        else:
            threshold = self.threshold

        window_px: int | None | Unset
        if isinstance(self.window_px, Unset):
            window_px = UNSET
        else:
            window_px = self.window_px

        offset: float | None | Unset
        if isinstance(self.offset, Unset):
            offset = UNSET
        else:
            offset = self.offset

        polarity: None | str | Unset
        if isinstance(self.polarity, Unset):
            polarity = UNSET
        elif isinstance(self.polarity, str):
            polarity = self.polarity
        else:
            polarity = self.polarity

        min_area_px: int | None | Unset
        if isinstance(self.min_area_px, Unset):
            min_area_px = UNSET
        else:
            min_area_px = self.min_area_px

        max_objects: int | None | Unset
        if isinstance(self.max_objects, Unset):
            max_objects = UNSET
        else:
            max_objects = self.max_objects

        field_dict: dict[str, Any] = {}

        field_dict.update({})
        if threshold is not UNSET:
            field_dict["threshold"] = threshold
        if window_px is not UNSET:
            field_dict["window_px"] = window_px
        if offset is not UNSET:
            field_dict["offset"] = offset
        if polarity is not UNSET:
            field_dict["polarity"] = polarity
        if min_area_px is not UNSET:
            field_dict["min_area_px"] = min_area_px
        if max_objects is not UNSET:
            field_dict["max_objects"] = max_objects

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)

        def _parse_threshold(data: object) -> float | None | ThresholdWord | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, str):
                    raise TypeError()
                componentsschemas_threshold_body_type_1 = check_threshold_word(data)

                return componentsschemas_threshold_body_type_1
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(float | None | ThresholdWord | Unset, data)

        threshold = _parse_threshold(d.pop("threshold", UNSET))

        def _parse_window_px(data: object) -> int | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(int | None | Unset, data)

        window_px = _parse_window_px(d.pop("window_px", UNSET))

        def _parse_offset(data: object) -> float | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(float | None | Unset, data)

        offset = _parse_offset(d.pop("offset", UNSET))

        def _parse_polarity(data: object) -> None | PolarityWord | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, str):
                    raise TypeError()
                polarity_type_0 = check_polarity_word(data)

                return polarity_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(None | PolarityWord | Unset, data)

        polarity = _parse_polarity(d.pop("polarity", UNSET))

        def _parse_min_area_px(data: object) -> int | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(int | None | Unset, data)

        min_area_px = _parse_min_area_px(d.pop("min_area_px", UNSET))

        def _parse_max_objects(data: object) -> int | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(int | None | Unset, data)

        max_objects = _parse_max_objects(d.pop("max_objects", UNSET))

        segmentation_options_body = cls(
            threshold=threshold,
            window_px=window_px,
            offset=offset,
            polarity=polarity,
            min_area_px=min_area_px,
            max_objects=max_objects,
        )

        return segmentation_options_body
