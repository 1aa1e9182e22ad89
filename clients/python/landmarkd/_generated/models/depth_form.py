from __future__ import annotations

import json
from collections.abc import Mapping
from io import BytesIO
from typing import TYPE_CHECKING, Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from .. import types
from ..types import UNSET, File, Unset

if TYPE_CHECKING:
    from ..models.depth_options_body import DepthOptionsBody
    from ..models.optics_body import OpticsBody


T = TypeVar("T", bound="DepthForm")


@_attrs_define
class DepthForm:
    """A near- and a far-focused picture, and what the lens is. Either `optics` or `calibration`."""

    near: File
    """ The near-focused picture. """
    far: File
    """ The far-focused picture. """
    optics: None | OpticsBody | Unset = UNSET
    calibration: None | str | Unset = UNSET
    """ Name of a calibration. """
    options: DepthOptionsBody | None | Unset = UNSET
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        from ..models.depth_options_body import DepthOptionsBody
        from ..models.optics_body import OpticsBody

        near = self.near.to_tuple()

        far = self.far.to_tuple()

        optics: dict[str, Any] | None | Unset
        if isinstance(self.optics, Unset):
            optics = UNSET
        elif isinstance(self.optics, OpticsBody):
            optics = self.optics.to_dict()
        else:
            optics = self.optics

        calibration: None | str | Unset
        if isinstance(self.calibration, Unset):
            calibration = UNSET
        else:
            calibration = self.calibration

        options: dict[str, Any] | None | Unset
        if isinstance(self.options, Unset):
            options = UNSET
        elif isinstance(self.options, DepthOptionsBody):
            options = self.options.to_dict()
        else:
            options = self.options

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "near": near,
                "far": far,
            }
        )
        if optics is not UNSET:
            field_dict["optics"] = optics
        if calibration is not UNSET:
            field_dict["calibration"] = calibration
        if options is not UNSET:
            field_dict["options"] = options

        return field_dict

    def to_multipart(self) -> types.RequestFiles:
        from ..models.depth_options_body import DepthOptionsBody
        from ..models.optics_body import OpticsBody

        files: types.RequestFiles = []

        files.append(("near", self.near.to_tuple()))

        files.append(("far", self.far.to_tuple()))

        if not isinstance(self.optics, Unset):
            if isinstance(self.optics, OpticsBody):
                files.append(("optics", (None, json.dumps(self.optics.to_dict()).encode(), "application/json")))
            else:
                files.append(("optics", (None, str(self.optics).encode(), "text/plain")))

        if not isinstance(self.calibration, Unset):
            if isinstance(self.calibration, str):
                files.append(("calibration", (None, str(self.calibration).encode(), "text/plain")))
            else:
                files.append(("calibration", (None, str(self.calibration).encode(), "text/plain")))

        if not isinstance(self.options, Unset):
            if isinstance(self.options, DepthOptionsBody):
                files.append(("options", (None, json.dumps(self.options.to_dict()).encode(), "application/json")))
            else:
                files.append(("options", (None, str(self.options).encode(), "text/plain")))

        for prop_name, prop in self.additional_properties.items():
            files.append((prop_name, (None, str(prop).encode(), "text/plain")))

        return files

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.depth_options_body import DepthOptionsBody
        from ..models.optics_body import OpticsBody

        d = dict(src_dict)
        near = File(payload=BytesIO(d.pop("near")))

        far = File(payload=BytesIO(d.pop("far")))

        def _parse_optics(data: object) -> None | OpticsBody | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                optics_type_0 = OpticsBody.from_dict(data)

                return optics_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(None | OpticsBody | Unset, data)

        optics = _parse_optics(d.pop("optics", UNSET))

        def _parse_calibration(data: object) -> None | str | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(None | str | Unset, data)

        calibration = _parse_calibration(d.pop("calibration", UNSET))

        def _parse_options(data: object) -> DepthOptionsBody | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                options_type_0 = DepthOptionsBody.from_dict(data)

                return options_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(DepthOptionsBody | None | Unset, data)

        options = _parse_options(d.pop("options", UNSET))

        depth_form = cls(
            near=near,
            far=far,
            optics=optics,
            calibration=calibration,
            options=options,
        )

        depth_form.additional_properties = d
        return depth_form

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
