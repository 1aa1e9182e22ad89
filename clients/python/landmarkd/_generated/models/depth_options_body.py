from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, cast

from attrs import define as _attrs_define

from ..models.auto_or_none_word import AutoOrNoneWord, check_auto_or_none_word
from ..models.auto_word import AutoWord, check_auto_word
from ..models.depth_method_word import DepthMethodWord, check_depth_method_word
from ..types import UNSET, Unset

T = TypeVar("T", bound="DepthOptionsBody")


@_attrs_define
class DepthOptionsBody:
    """Options of a depth map. What is absent has its default."""

    method: DepthMethodWord | None | Unset = UNSET
    window: AutoWord | float | None | Unset = UNSET
    align: AutoOrNoneWord | None | Unset = UNSET
    photometric: AutoOrNoneWord | None | Unset = UNSET
    median: int | None | Unset = 0
    """ Side of a median over the depths: 0 (none, the default), 3 or 5. """

    def to_dict(self) -> dict[str, Any]:
        method: None | str | Unset
        if isinstance(self.method, Unset):
            method = UNSET
        elif isinstance(self.method, str):
            method = self.method
        else:
            method = self.method

        window: float | None | str | Unset
        if isinstance(self.window, Unset):
            window = UNSET
        elif isinstance(self.window, str):
            window = self.window
        else:
            window = self.window

        align: None | str | Unset
        if isinstance(self.align, Unset):
            align = UNSET
        elif isinstance(self.align, str):
            align = self.align
        else:
            align = self.align

        photometric: None | str | Unset
        if isinstance(self.photometric, Unset):
            photometric = UNSET
        elif isinstance(self.photometric, str):
            photometric = self.photometric
        else:
            photometric = self.photometric

        median: int | None | Unset
        if isinstance(self.median, Unset):
            median = UNSET
        else:
            median = self.median

        field_dict: dict[str, Any] = {}

        field_dict.update({})
        if method is not UNSET:
            field_dict["method"] = method
        if window is not UNSET:
            field_dict["window"] = window
        if align is not UNSET:
            field_dict["align"] = align
        if photometric is not UNSET:
            field_dict["photometric"] = photometric
        if median is not UNSET:
            field_dict["median"] = median

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)

        def _parse_method(data: object) -> DepthMethodWord | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, str):
                    raise TypeError()
                method_type_0 = check_depth_method_word(data)

                return method_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(DepthMethodWord | None | Unset, data)

        method = _parse_method(d.pop("method", UNSET))

        def _parse_window(data: object) -> AutoWord | float | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, str):
                    raise TypeError()
                componentsschemas_window_body_type_1 = check_auto_word(data)

                return componentsschemas_window_body_type_1
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(AutoWord | float | None | Unset, data)

        window = _parse_window(d.pop("window", UNSET))

        def _parse_align(data: object) -> AutoOrNoneWord | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, str):
                    raise TypeError()
                align_type_0 = check_auto_or_none_word(data)

                return align_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(AutoOrNoneWord | None | Unset, data)

        align = _parse_align(d.pop("align", UNSET))

        def _parse_photometric(data: object) -> AutoOrNoneWord | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, str):
                    raise TypeError()
                photometric_type_0 = check_auto_or_none_word(data)

                return photometric_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(AutoOrNoneWord | None | Unset, data)

        photometric = _parse_photometric(d.pop("photometric", UNSET))

        def _parse_median(data: object) -> int | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(int | None | Unset, data)

        median = _parse_median(d.pop("median", UNSET))

        depth_options_body = cls(
            method=method,
            window=window,
            align=align,
            photometric=photometric,
            median=median,
        )

        return depth_options_body
