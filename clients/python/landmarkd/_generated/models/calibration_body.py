from __future__ import annotations

import datetime
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field
from dateutil.parser import isoparse

from ..types import UNSET, Unset

if TYPE_CHECKING:
    from ..models.filters_body import FiltersBody
    from ..models.image_body import ImageBody
    from ..models.noise_body import NoiseBody
    from ..models.optics_body import OpticsBody
    from ..models.photometric_body import PhotometricBody
    from ..models.registration_body import RegistrationBody
    from ..models.residual_body import ResidualBody
    from ..models.table_body import TableBody


T = TypeVar("T", bound="CalibrationBody")


@_attrs_define
class CalibrationBody:
    """What is known of a rig: its optics, and what was measured with it."""

    name: str
    version: int
    """ Version of the document's shape. """
    optics: OpticsBody
    """ One lens before two sensors. Exactly one of `aperture_mm` and `f_number`, and exactly one of `near_plane_mm`
    and
    `near_focus_mm`. """
    near_focus_mm: float
    """ The distance that the near-focused picture is focused at. """
    far_focus_mm: float
    """ The distance that the far-focused picture is focused at. """
    range_mm: float
    """ From the near to the far focus distance: the working range. """
    largest_blur_px: float
    """ The largest blur within the working range. """
    advice: list[str]
    """ What would make it better, for people. """
    created_at: datetime.datetime
    updated_at: datetime.datetime
    image: ImageBody | None | Unset = UNSET
    stated_optics: None | OpticsBody | Unset = UNSET
    registration: None | RegistrationBody | Unset = UNSET
    photometric: None | PhotometricBody | Unset = UNSET
    noise: NoiseBody | None | Unset = UNSET
    filters: FiltersBody | None | Unset = UNSET
    table: None | TableBody | Unset = UNSET
    residual: None | ResidualBody | Unset = UNSET
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        from ..models.filters_body import FiltersBody
        from ..models.image_body import ImageBody
        from ..models.noise_body import NoiseBody
        from ..models.optics_body import OpticsBody
        from ..models.photometric_body import PhotometricBody
        from ..models.registration_body import RegistrationBody
        from ..models.residual_body import ResidualBody
        from ..models.table_body import TableBody

        name = self.name

        version = self.version

        optics = self.optics.to_dict()

        near_focus_mm = self.near_focus_mm

        far_focus_mm = self.far_focus_mm

        range_mm = self.range_mm

        largest_blur_px = self.largest_blur_px

        advice = self.advice

        created_at = self.created_at.isoformat()

        updated_at = self.updated_at.isoformat()

        image: dict[str, Any] | None | Unset
        if isinstance(self.image, Unset):
            image = UNSET
        elif isinstance(self.image, ImageBody):
            image = self.image.to_dict()
        else:
            image = self.image

        stated_optics: dict[str, Any] | None | Unset
        if isinstance(self.stated_optics, Unset):
            stated_optics = UNSET
        elif isinstance(self.stated_optics, OpticsBody):
            stated_optics = self.stated_optics.to_dict()
        else:
            stated_optics = self.stated_optics

        registration: dict[str, Any] | None | Unset
        if isinstance(self.registration, Unset):
            registration = UNSET
        elif isinstance(self.registration, RegistrationBody):
            registration = self.registration.to_dict()
        else:
            registration = self.registration

        photometric: dict[str, Any] | None | Unset
        if isinstance(self.photometric, Unset):
            photometric = UNSET
        elif isinstance(self.photometric, PhotometricBody):
            photometric = self.photometric.to_dict()
        else:
            photometric = self.photometric

        noise: dict[str, Any] | None | Unset
        if isinstance(self.noise, Unset):
            noise = UNSET
        elif isinstance(self.noise, NoiseBody):
            noise = self.noise.to_dict()
        else:
            noise = self.noise

        filters: dict[str, Any] | None | Unset
        if isinstance(self.filters, Unset):
            filters = UNSET
        elif isinstance(self.filters, FiltersBody):
            filters = self.filters.to_dict()
        else:
            filters = self.filters

        table: dict[str, Any] | None | Unset
        if isinstance(self.table, Unset):
            table = UNSET
        elif isinstance(self.table, TableBody):
            table = self.table.to_dict()
        else:
            table = self.table

        residual: dict[str, Any] | None | Unset
        if isinstance(self.residual, Unset):
            residual = UNSET
        elif isinstance(self.residual, ResidualBody):
            residual = self.residual.to_dict()
        else:
            residual = self.residual

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "name": name,
                "version": version,
                "optics": optics,
                "near_focus_mm": near_focus_mm,
                "far_focus_mm": far_focus_mm,
                "range_mm": range_mm,
                "largest_blur_px": largest_blur_px,
                "advice": advice,
                "created_at": created_at,
                "updated_at": updated_at,
            }
        )
        if image is not UNSET:
            field_dict["image"] = image
        if stated_optics is not UNSET:
            field_dict["stated_optics"] = stated_optics
        if registration is not UNSET:
            field_dict["registration"] = registration
        if photometric is not UNSET:
            field_dict["photometric"] = photometric
        if noise is not UNSET:
            field_dict["noise"] = noise
        if filters is not UNSET:
            field_dict["filters"] = filters
        if table is not UNSET:
            field_dict["table"] = table
        if residual is not UNSET:
            field_dict["residual"] = residual

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.filters_body import FiltersBody
        from ..models.image_body import ImageBody
        from ..models.noise_body import NoiseBody
        from ..models.optics_body import OpticsBody
        from ..models.photometric_body import PhotometricBody
        from ..models.registration_body import RegistrationBody
        from ..models.residual_body import ResidualBody
        from ..models.table_body import TableBody

        d = dict(src_dict)
        name = d.pop("name")

        version = d.pop("version")

        optics = OpticsBody.from_dict(d.pop("optics"))

        near_focus_mm = d.pop("near_focus_mm")

        far_focus_mm = d.pop("far_focus_mm")

        range_mm = d.pop("range_mm")

        largest_blur_px = d.pop("largest_blur_px")

        advice = cast(list[str], d.pop("advice"))

        created_at = isoparse(d.pop("created_at"))

        updated_at = isoparse(d.pop("updated_at"))

        def _parse_image(data: object) -> ImageBody | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                image_type_0 = ImageBody.from_dict(data)

                return image_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(ImageBody | None | Unset, data)

        image = _parse_image(d.pop("image", UNSET))

        def _parse_stated_optics(data: object) -> None | OpticsBody | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                stated_optics_type_0 = OpticsBody.from_dict(data)

                return stated_optics_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(None | OpticsBody | Unset, data)

        stated_optics = _parse_stated_optics(d.pop("stated_optics", UNSET))

        def _parse_registration(data: object) -> None | RegistrationBody | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                registration_type_0 = RegistrationBody.from_dict(data)

                return registration_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(None | RegistrationBody | Unset, data)

        registration = _parse_registration(d.pop("registration", UNSET))

        def _parse_photometric(data: object) -> None | PhotometricBody | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                photometric_type_0 = PhotometricBody.from_dict(data)

                return photometric_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(None | PhotometricBody | Unset, data)

        photometric = _parse_photometric(d.pop("photometric", UNSET))

        def _parse_noise(data: object) -> NoiseBody | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                noise_type_0 = NoiseBody.from_dict(data)

                return noise_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(NoiseBody | None | Unset, data)

        noise = _parse_noise(d.pop("noise", UNSET))

        def _parse_filters(data: object) -> FiltersBody | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                filters_type_0 = FiltersBody.from_dict(data)

                return filters_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(FiltersBody | None | Unset, data)

        filters = _parse_filters(d.pop("filters", UNSET))

        def _parse_table(data: object) -> None | TableBody | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                table_type_0 = TableBody.from_dict(data)

                return table_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(None | TableBody | Unset, data)

        table = _parse_table(d.pop("table", UNSET))

        def _parse_residual(data: object) -> None | ResidualBody | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                residual_type_0 = ResidualBody.from_dict(data)

                return residual_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(None | ResidualBody | Unset, data)

        residual = _parse_residual(d.pop("residual", UNSET))

        calibration_body = cls(
            name=name,
            version=version,
            optics=optics,
            near_focus_mm=near_focus_mm,
            far_focus_mm=far_focus_mm,
            range_mm=range_mm,
            largest_blur_px=largest_blur_px,
            advice=advice,
            created_at=created_at,
            updated_at=updated_at,
            image=image,
            stated_optics=stated_optics,
            registration=registration,
            photometric=photometric,
            noise=noise,
            filters=filters,
            table=table,
            residual=residual,
        )

        calibration_body.additional_properties = d
        return calibration_body

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
