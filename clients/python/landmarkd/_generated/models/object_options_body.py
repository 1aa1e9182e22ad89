from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, cast

from attrs import define as _attrs_define

from ..models.auto_word import AutoWord, check_auto_word
from ..models.distance_word import DistanceWord, check_distance_word
from ..models.resize_word import ResizeWord, check_resize_word
from ..models.search_word import SearchWord, check_search_word
from ..models.stages_word import StagesWord, check_stages_word
from ..types import UNSET, Unset

T = TypeVar("T", bound="ObjectOptionsBody")


@_attrs_define
class ObjectOptionsBody:
    """Options of a database of kind `objects`."""

    width_px: int | None | Unset = UNSET
    """ Width of the database's pictures; null, as the height then: the commonest size among the exemplars. """
    height_px: int | None | Unset = UNSET
    """ Height of the database's pictures. """
    resize: None | ResizeWord | Unset = UNSET
    smoothing: float | None | Unset = UNSET
    """ Standard deviation of the Gaussian that pictures are smoothed with, as a part of their longer side. """
    segment: bool | None | Unset = UNSET
    """ Whether the object is cut out of its picture first, in training and in recognition: the largest region that
    stands out from the background, in the square about its centroid, on black. Pictures are then square, of 128 px
    unless a size is given. """
    dimension: AutoWord | int | None | Unset = UNSET
    stages: None | StagesWord | Unset = UNSET
    search: None | SearchWord | Unset = UNSET
    distance: DistanceWord | None | Unset = UNSET
    accept: float | None | Unset = UNSET
    """ Part of the known objects that is to be accepted. """

    def to_dict(self) -> dict[str, Any]:
        width_px: int | None | Unset
        if isinstance(self.width_px, Unset):
            width_px = UNSET
        else:
            width_px = self.width_px

        height_px: int | None | Unset
        if isinstance(self.height_px, Unset):
            height_px = UNSET
        else:
            height_px = self.height_px

        resize: None | str | Unset
        if isinstance(self.resize, Unset):
            resize = UNSET
        elif isinstance(self.resize, str):
            resize = self.resize
        else:
            resize = self.resize

        smoothing: float | None | Unset
        if isinstance(self.smoothing, Unset):
            smoothing = UNSET
        else:
            smoothing = self.smoothing

        segment: bool | None | Unset
        if isinstance(self.segment, Unset):
            segment = UNSET
        else:
            segment = self.segment

        dimension: int | None | str | Unset
        if isinstance(self.dimension, Unset):
            dimension = UNSET
        elif isinstance(self.dimension, str):
            dimension = self.dimension
        else:
            dimension = self.dimension

        stages: None | str | Unset
        if isinstance(self.stages, Unset):
            stages = UNSET
        elif isinstance(self.stages, str):
            stages = self.stages
        else:
            stages = self.stages

        search: None | str | Unset
        if isinstance(self.search, Unset):
            search = UNSET
        elif isinstance(self.search, str):
            search = self.search
        else:
            search = self.search

        distance: None | str | Unset
        if isinstance(self.distance, Unset):
            distance = UNSET
        elif isinstance(self.distance, str):
            distance = self.distance
        else:
            distance = self.distance

        accept: float | None | Unset
        if isinstance(self.accept, Unset):
            accept = UNSET
        else:
            accept = self.accept

        field_dict: dict[str, Any] = {}

        field_dict.update({})
        if width_px is not UNSET:
            field_dict["width_px"] = width_px
        if height_px is not UNSET:
            field_dict["height_px"] = height_px
        if resize is not UNSET:
            field_dict["resize"] = resize
        if smoothing is not UNSET:
            field_dict["smoothing"] = smoothing
        if segment is not UNSET:
            field_dict["segment"] = segment
        if dimension is not UNSET:
            field_dict["dimension"] = dimension
        if stages is not UNSET:
            field_dict["stages"] = stages
        if search is not UNSET:
            field_dict["search"] = search
        if distance is not UNSET:
            field_dict["distance"] = distance
        if accept is not UNSET:
            field_dict["accept"] = accept

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)

        def _parse_width_px(data: object) -> int | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(int | None | Unset, data)

        width_px = _parse_width_px(d.pop("width_px", UNSET))

        def _parse_height_px(data: object) -> int | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(int | None | Unset, data)

        height_px = _parse_height_px(d.pop("height_px", UNSET))

        def _parse_resize(data: object) -> None | ResizeWord | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, str):
                    raise TypeError()
                resize_type_0 = check_resize_word(data)

                return resize_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(None | ResizeWord | Unset, data)

        resize = _parse_resize(d.pop("resize", UNSET))

        def _parse_smoothing(data: object) -> float | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(float | None | Unset, data)

        smoothing = _parse_smoothing(d.pop("smoothing", UNSET))

        def _parse_segment(data: object) -> bool | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(bool | None | Unset, data)

        segment = _parse_segment(d.pop("segment", UNSET))

        def _parse_dimension(data: object) -> AutoWord | int | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, str):
                    raise TypeError()
                componentsschemas_dimension_body_type_1 = check_auto_word(data)

                return componentsschemas_dimension_body_type_1
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(AutoWord | int | None | Unset, data)

        dimension = _parse_dimension(d.pop("dimension", UNSET))

        def _parse_stages(data: object) -> None | StagesWord | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, str):
                    raise TypeError()
                stages_type_0 = check_stages_word(data)

                return stages_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(None | StagesWord | Unset, data)

        stages = _parse_stages(d.pop("stages", UNSET))

        def _parse_search(data: object) -> None | SearchWord | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, str):
                    raise TypeError()
                search_type_0 = check_search_word(data)

                return search_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(None | SearchWord | Unset, data)

        search = _parse_search(d.pop("search", UNSET))

        def _parse_distance(data: object) -> DistanceWord | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, str):
                    raise TypeError()
                distance_type_0 = check_distance_word(data)

                return distance_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(DistanceWord | None | Unset, data)

        distance = _parse_distance(d.pop("distance", UNSET))

        def _parse_accept(data: object) -> float | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(float | None | Unset, data)

        accept = _parse_accept(d.pop("accept", UNSET))

        object_options_body = cls(
            width_px=width_px,
            height_px=height_px,
            resize=resize,
            smoothing=smoothing,
            segment=segment,
            dimension=dimension,
            stages=stages,
            search=search,
            distance=distance,
            accept=accept,
        )

        return object_options_body
