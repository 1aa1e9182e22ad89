from __future__ import annotations

from collections.abc import Mapping
from io import BytesIO
from typing import Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from .. import types
from ..types import UNSET, File, FileTypes, Unset

T = TypeVar("T", bound="InspectionForm")


@_attrs_define
class InspectionForm:
    """The table, and with `near` and `far` a focal pair of a part or of the table."""

    overview: File
    """ The overview camera's picture. """
    near: File | None | Unset = UNSET
    """ The near-focused picture; with `far`, and a calibration in the workcell. """
    far: File | None | Unset = UNSET
    """ The far-focused picture. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        overview = self.overview.to_tuple()

        near: FileTypes | None | Unset
        if isinstance(self.near, Unset):
            near = UNSET
        elif isinstance(self.near, File):
            near = self.near.to_tuple()

        else:
            near = self.near

        far: FileTypes | None | Unset
        if isinstance(self.far, Unset):
            far = UNSET
        elif isinstance(self.far, File):
            far = self.far.to_tuple()

        else:
            far = self.far

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "overview": overview,
            }
        )
        if near is not UNSET:
            field_dict["near"] = near
        if far is not UNSET:
            field_dict["far"] = far

        return field_dict

    def to_multipart(self) -> types.RequestFiles:
        files: types.RequestFiles = []

        files.append(("overview", self.overview.to_tuple()))

        if not isinstance(self.near, Unset):
            if isinstance(self.near, File):
                files.append(("near", self.near.to_tuple()))
            else:
                files.append(("near", (None, str(self.near).encode(), "text/plain")))

        if not isinstance(self.far, Unset):
            if isinstance(self.far, File):
                files.append(("far", self.far.to_tuple()))
            else:
                files.append(("far", (None, str(self.far).encode(), "text/plain")))

        for prop_name, prop in self.additional_properties.items():
            files.append((prop_name, (None, str(prop).encode(), "text/plain")))

        return files

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        overview = File(payload=BytesIO(d.pop("overview")))

        def _parse_near(data: object) -> File | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, bytes):
                    raise TypeError()
                near_type_0 = File(payload=BytesIO(data))

                return near_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(File | None | Unset, data)

        near = _parse_near(d.pop("near", UNSET))

        def _parse_far(data: object) -> File | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, bytes):
                    raise TypeError()
                far_type_0 = File(payload=BytesIO(data))

                return far_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(File | None | Unset, data)

        far = _parse_far(d.pop("far", UNSET))

        inspection_form = cls(
            overview=overview,
            near=near,
            far=far,
        )

        inspection_form.additional_properties = d
        return inspection_form

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
