from __future__ import annotations

from collections.abc import Mapping
from io import BytesIO
from typing import Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from .. import types
from ..types import UNSET, File, FileTypes, Unset

T = TypeVar("T", bound="RegistrationForm")


@_attrs_define
class RegistrationForm:
    """Pictures to register by."""

    near: File
    """ The near-focused picture of a flat target with fine irregular texture, within the working range. """
    far: File
    """ The far-focused picture of it. """
    dark_near: File | None | Unset = UNSET
    """ The near-focused sensor's picture in the dark; with `dark_far`. """
    dark_far: File | None | Unset = UNSET
    flat_near: File | None | Unset = UNSET
    """ The near-focused sensor's picture of an evenly lit white surface; with `flat_far`. """
    flat_far: File | None | Unset = UNSET
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        near = self.near.to_tuple()

        far = self.far.to_tuple()

        dark_near: FileTypes | None | Unset
        if isinstance(self.dark_near, Unset):
            dark_near = UNSET
        elif isinstance(self.dark_near, File):
            dark_near = self.dark_near.to_tuple()

        else:
            dark_near = self.dark_near

        dark_far: FileTypes | None | Unset
        if isinstance(self.dark_far, Unset):
            dark_far = UNSET
        elif isinstance(self.dark_far, File):
            dark_far = self.dark_far.to_tuple()

        else:
            dark_far = self.dark_far

        flat_near: FileTypes | None | Unset
        if isinstance(self.flat_near, Unset):
            flat_near = UNSET
        elif isinstance(self.flat_near, File):
            flat_near = self.flat_near.to_tuple()

        else:
            flat_near = self.flat_near

        flat_far: FileTypes | None | Unset
        if isinstance(self.flat_far, Unset):
            flat_far = UNSET
        elif isinstance(self.flat_far, File):
            flat_far = self.flat_far.to_tuple()

        else:
            flat_far = self.flat_far

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "near": near,
                "far": far,
            }
        )
        if dark_near is not UNSET:
            field_dict["dark_near"] = dark_near
        if dark_far is not UNSET:
            field_dict["dark_far"] = dark_far
        if flat_near is not UNSET:
            field_dict["flat_near"] = flat_near
        if flat_far is not UNSET:
            field_dict["flat_far"] = flat_far

        return field_dict

    def to_multipart(self) -> types.RequestFiles:
        files: types.RequestFiles = []

        files.append(("near", self.near.to_tuple()))

        files.append(("far", self.far.to_tuple()))

        if not isinstance(self.dark_near, Unset):
            if isinstance(self.dark_near, File):
                files.append(("dark_near", self.dark_near.to_tuple()))
            else:
                files.append(("dark_near", (None, str(self.dark_near).encode(), "text/plain")))

        if not isinstance(self.dark_far, Unset):
            if isinstance(self.dark_far, File):
                files.append(("dark_far", self.dark_far.to_tuple()))
            else:
                files.append(("dark_far", (None, str(self.dark_far).encode(), "text/plain")))

        if not isinstance(self.flat_near, Unset):
            if isinstance(self.flat_near, File):
                files.append(("flat_near", self.flat_near.to_tuple()))
            else:
                files.append(("flat_near", (None, str(self.flat_near).encode(), "text/plain")))

        if not isinstance(self.flat_far, Unset):
            if isinstance(self.flat_far, File):
                files.append(("flat_far", self.flat_far.to_tuple()))
            else:
                files.append(("flat_far", (None, str(self.flat_far).encode(), "text/plain")))

        for prop_name, prop in self.additional_properties.items():
            files.append((prop_name, (None, str(prop).encode(), "text/plain")))

        return files

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        near = File(payload=BytesIO(d.pop("near")))

        far = File(payload=BytesIO(d.pop("far")))

        def _parse_dark_near(data: object) -> File | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, bytes):
                    raise TypeError()
                dark_near_type_0 = File(payload=BytesIO(data))

                return dark_near_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(File | None | Unset, data)

        dark_near = _parse_dark_near(d.pop("dark_near", UNSET))

        def _parse_dark_far(data: object) -> File | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, bytes):
                    raise TypeError()
                dark_far_type_0 = File(payload=BytesIO(data))

                return dark_far_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(File | None | Unset, data)

        dark_far = _parse_dark_far(d.pop("dark_far", UNSET))

        def _parse_flat_near(data: object) -> File | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, bytes):
                    raise TypeError()
                flat_near_type_0 = File(payload=BytesIO(data))

                return flat_near_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(File | None | Unset, data)

        flat_near = _parse_flat_near(d.pop("flat_near", UNSET))

        def _parse_flat_far(data: object) -> File | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, bytes):
                    raise TypeError()
                flat_far_type_0 = File(payload=BytesIO(data))

                return flat_far_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(File | None | Unset, data)

        flat_far = _parse_flat_far(d.pop("flat_far", UNSET))

        registration_form = cls(
            near=near,
            far=far,
            dark_near=dark_near,
            dark_far=dark_far,
            flat_near=flat_near,
            flat_far=flat_far,
        )

        registration_form.additional_properties = d
        return registration_form

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
