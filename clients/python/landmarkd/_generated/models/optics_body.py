from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, cast

from attrs import define as _attrs_define

from ..types import UNSET, Unset

T = TypeVar("T", bound="OpticsBody")


@_attrs_define
class OpticsBody:
    """One lens before two sensors. Exactly one of `aperture_mm` and `f_number`, and exactly one of `near_plane_mm` and
    `near_focus_mm`.

    """

    focal_length_mm: float
    plane_separation_mm: float
    """ How much nearer to the lens the sensor of the far-focused picture stands. """
    pixel_pitch_um: float
    """ Side of a pixel, in µm. """
    telecentric: bool
    """ Whether a stop in the front focal plane keeps both pictures at one scale. """
    aperture_mm: float | None | Unset = UNSET
    """ Diameter of the aperture. """
    f_number: float | None | Unset = UNSET
    """ Focal length over diameter. """
    near_plane_mm: float | None | Unset = UNSET
    """ Distance from the lens to the sensor of the near-focused picture, the farther of the two sensors. """
    near_focus_mm: float | None | Unset = UNSET
    """ The distance in the scene that the near-focused picture is focused at. """
    principal_point_px: list[float] | None | Unset = UNSET
    """ Where the optical axis meets the picture; its middle by default. """

    def to_dict(self) -> dict[str, Any]:
        focal_length_mm = self.focal_length_mm

        plane_separation_mm = self.plane_separation_mm

        pixel_pitch_um = self.pixel_pitch_um

        telecentric = self.telecentric

        aperture_mm: float | None | Unset
        if isinstance(self.aperture_mm, Unset):
            aperture_mm = UNSET
        else:
            aperture_mm = self.aperture_mm

        f_number: float | None | Unset
        if isinstance(self.f_number, Unset):
            f_number = UNSET
        else:
            f_number = self.f_number

        near_plane_mm: float | None | Unset
        if isinstance(self.near_plane_mm, Unset):
            near_plane_mm = UNSET
        else:
            near_plane_mm = self.near_plane_mm

        near_focus_mm: float | None | Unset
        if isinstance(self.near_focus_mm, Unset):
            near_focus_mm = UNSET
        else:
            near_focus_mm = self.near_focus_mm

        principal_point_px: list[float] | None | Unset
        if isinstance(self.principal_point_px, Unset):
            principal_point_px = UNSET
        elif isinstance(self.principal_point_px, list):
            principal_point_px = self.principal_point_px

        else:
            principal_point_px = self.principal_point_px

        field_dict: dict[str, Any] = {}

        field_dict.update(
            {
                "focal_length_mm": focal_length_mm,
                "plane_separation_mm": plane_separation_mm,
                "pixel_pitch_um": pixel_pitch_um,
                "telecentric": telecentric,
            }
        )
        if aperture_mm is not UNSET:
            field_dict["aperture_mm"] = aperture_mm
        if f_number is not UNSET:
            field_dict["f_number"] = f_number
        if near_plane_mm is not UNSET:
            field_dict["near_plane_mm"] = near_plane_mm
        if near_focus_mm is not UNSET:
            field_dict["near_focus_mm"] = near_focus_mm
        if principal_point_px is not UNSET:
            field_dict["principal_point_px"] = principal_point_px

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        focal_length_mm = d.pop("focal_length_mm")

        plane_separation_mm = d.pop("plane_separation_mm")

        pixel_pitch_um = d.pop("pixel_pitch_um")

        telecentric = d.pop("telecentric")

        def _parse_aperture_mm(data: object) -> float | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(float | None | Unset, data)

        aperture_mm = _parse_aperture_mm(d.pop("aperture_mm", UNSET))

        def _parse_f_number(data: object) -> float | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(float | None | Unset, data)

        f_number = _parse_f_number(d.pop("f_number", UNSET))

        def _parse_near_plane_mm(data: object) -> float | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(float | None | Unset, data)

        near_plane_mm = _parse_near_plane_mm(d.pop("near_plane_mm", UNSET))

        def _parse_near_focus_mm(data: object) -> float | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(float | None | Unset, data)

        near_focus_mm = _parse_near_focus_mm(d.pop("near_focus_mm", UNSET))

        def _parse_principal_point_px(data: object) -> list[float] | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, list):
                    raise TypeError()
                principal_point_px_type_0 = cast(list[float], data)

                return principal_point_px_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(list[float] | None | Unset, data)

        principal_point_px = _parse_principal_point_px(d.pop("principal_point_px", UNSET))

        optics_body = cls(
            focal_length_mm=focal_length_mm,
            plane_separation_mm=plane_separation_mm,
            pixel_pitch_um=pixel_pitch_um,
            telecentric=telecentric,
            aperture_mm=aperture_mm,
            f_number=f_number,
            near_plane_mm=near_plane_mm,
            near_focus_mm=near_focus_mm,
            principal_point_px=principal_point_px,
        )

        return optics_body
