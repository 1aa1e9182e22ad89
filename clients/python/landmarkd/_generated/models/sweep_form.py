from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from .. import types
from ..types import UNSET, Unset

if TYPE_CHECKING:
    from ..models.plane_line import PlaneLine
    from ..models.sweep_options_body import SweepOptionsBody


T = TypeVar("T", bound="SweepForm")


@_attrs_define
class SweepForm:
    """A form with a manifest, and one part for each picture that it names."""

    manifest: list[PlaneLine]
    """ JSON: planes at 5 known depths or more, better 9 to 21, that reach past both focus distances. """
    options: None | SweepOptionsBody | Unset = UNSET
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        from ..models.sweep_options_body import SweepOptionsBody

        manifest = []
        for manifest_item_data in self.manifest:
            manifest_item = manifest_item_data.to_dict()
            manifest.append(manifest_item)

        options: dict[str, Any] | None | Unset
        if isinstance(self.options, Unset):
            options = UNSET
        elif isinstance(self.options, SweepOptionsBody):
            options = self.options.to_dict()
        else:
            options = self.options

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "manifest": manifest,
            }
        )
        if options is not UNSET:
            field_dict["options"] = options

        return field_dict

    def to_multipart(self) -> types.RequestFiles:
        from ..models.sweep_options_body import SweepOptionsBody

        files: types.RequestFiles = []

        for manifest_item_element in self.manifest:
            files.append(("manifest", (None, json.dumps(manifest_item_element.to_dict()).encode(), "application/json")))

        if not isinstance(self.options, Unset):
            if isinstance(self.options, SweepOptionsBody):
                files.append(("options", (None, json.dumps(self.options.to_dict()).encode(), "application/json")))
            else:
                files.append(("options", (None, str(self.options).encode(), "text/plain")))

        for prop_name, prop in self.additional_properties.items():
            files.append((prop_name, (None, str(prop).encode(), "text/plain")))

        return files

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.plane_line import PlaneLine
        from ..models.sweep_options_body import SweepOptionsBody

        d = dict(src_dict)
        manifest = []
        _manifest = d.pop("manifest")
        for manifest_item_data in _manifest:
            manifest_item = PlaneLine.from_dict(manifest_item_data)

            manifest.append(manifest_item)

        def _parse_options(data: object) -> None | SweepOptionsBody | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                options_type_0 = SweepOptionsBody.from_dict(data)

                return options_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(None | SweepOptionsBody | Unset, data)

        options = _parse_options(d.pop("options", UNSET))

        sweep_form = cls(
            manifest=manifest,
            options=options,
        )

        sweep_form.additional_properties = d
        return sweep_form

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
