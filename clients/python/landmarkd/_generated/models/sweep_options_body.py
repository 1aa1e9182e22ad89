from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, cast

from attrs import define as _attrs_define

from ..models.depth_method_word import DepthMethodWord, check_depth_method_word
from ..types import UNSET, Unset

T = TypeVar("T", bound="SweepOptionsBody")


@_attrs_define
class SweepOptionsBody:
    """How a sweep is to be measured."""

    method: DepthMethodWord | None | Unset = UNSET
    fit_optics: bool | None | Unset = False
    """ Whether aperture, separation and near plane are fitted to the planes first. """

    def to_dict(self) -> dict[str, Any]:
        method: None | str | Unset
        if isinstance(self.method, Unset):
            method = UNSET
        elif isinstance(self.method, str):
            method = self.method
        else:
            method = self.method

        fit_optics: bool | None | Unset
        if isinstance(self.fit_optics, Unset):
            fit_optics = UNSET
        else:
            fit_optics = self.fit_optics

        field_dict: dict[str, Any] = {}

        field_dict.update({})
        if method is not UNSET:
            field_dict["method"] = method
        if fit_optics is not UNSET:
            field_dict["fit_optics"] = fit_optics

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

        def _parse_fit_optics(data: object) -> bool | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(bool | None | Unset, data)

        fit_optics = _parse_fit_optics(d.pop("fit_optics", UNSET))

        sweep_options_body = cls(
            method=method,
            fit_optics=fit_optics,
        )

        return sweep_options_body
