from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from ..models.auto_word import AutoWord, check_auto_word
from ..models.depth_method_word import DepthMethodWord, check_depth_method_word
from ..types import UNSET, Unset

if TYPE_CHECKING:
    from ..models.depth_map_body_flags import DepthMapBodyFlags
    from ..models.depth_span_body import DepthSpanBody
    from ..models.depth_timings import DepthTimings
    from ..models.header_echo import HeaderEcho


T = TypeVar("T", bound="DepthMapBody")


@_attrs_define
class DepthMapBody:
    """How far away everything is, in short."""

    header: HeaderEcho
    """ What the robot says about its frame, as an answer echoes it. """
    method: DepthMethodWord
    """ What depth is read from: `gram`, the depth that explains both pictures best; `stm`, a closed form, the
    cheapest; `laplacian`, the paper's, which needs a calibration with a sweep by this method. """
    window: AutoWord | float
    """ The standard deviation of a Gaussian window in pixels, or `auto`: as large as the texture needs, pixel by
    pixel. """
    width_px: int
    height_px: int
    near_focus_mm: float
    """ The distance that the near-focused picture is focused at. """
    far_focus_mm: float
    """ The distance that the far-focused picture is focused at. """
    range_mm: float
    """ From the near to the far focus distance: the working range. """
    largest_blur_px: float
    """ The largest blur within the working range. """
    coverage: float
    """ Part of the pixels that have a depth. """
    shift_px: list[float]
    """ By how much the far-focused picture was displaced; it was moved back. """
    gain: float
    """ What the far-focused picture was multiplied by. """
    flags: DepthMapBodyFlags
    """ Pixels without a depth, by the reason: `low_texture`, `saturated`, `out_of_range`, `inconsistent`, `border`,
    `ambiguous`. """
    warnings: list[str]
    """ Reasons to doubt the whole: `shifted`, `shift_unknown`, `gain_off`, `many_inconsistent`, `low_coverage`,
    `near_far_swapped`. """
    timings_ms: DepthTimings
    """ How long the parts of a depth map took, in milliseconds. """
    calibration: None | str | Unset = UNSET
    """ The calibration that was used; null when the form had the optics. """
    depth_mm: DepthSpanBody | None | Unset = UNSET
    noise_sigma: float | None | Unset = UNSET
    """ Noise of a picture in grey levels of 255, as the method sees it; null if it can't. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        from ..models.depth_span_body import DepthSpanBody

        header = self.header.to_dict()

        method: str = self.method

        window: float | str
        if isinstance(self.window, str):
            window = self.window
        else:
            window = self.window

        width_px = self.width_px

        height_px = self.height_px

        near_focus_mm = self.near_focus_mm

        far_focus_mm = self.far_focus_mm

        range_mm = self.range_mm

        largest_blur_px = self.largest_blur_px

        coverage = self.coverage

        shift_px = self.shift_px

        gain = self.gain

        flags = self.flags.to_dict()

        warnings = self.warnings

        timings_ms = self.timings_ms.to_dict()

        calibration: None | str | Unset
        if isinstance(self.calibration, Unset):
            calibration = UNSET
        else:
            calibration = self.calibration

        depth_mm: dict[str, Any] | None | Unset
        if isinstance(self.depth_mm, Unset):
            depth_mm = UNSET
        elif isinstance(self.depth_mm, DepthSpanBody):
            depth_mm = self.depth_mm.to_dict()
        else:
            depth_mm = self.depth_mm

        noise_sigma: float | None | Unset
        if isinstance(self.noise_sigma, Unset):
            noise_sigma = UNSET
        else:
            noise_sigma = self.noise_sigma

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "header": header,
                "method": method,
                "window": window,
                "width_px": width_px,
                "height_px": height_px,
                "near_focus_mm": near_focus_mm,
                "far_focus_mm": far_focus_mm,
                "range_mm": range_mm,
                "largest_blur_px": largest_blur_px,
                "coverage": coverage,
                "shift_px": shift_px,
                "gain": gain,
                "flags": flags,
                "warnings": warnings,
                "timings_ms": timings_ms,
            }
        )
        if calibration is not UNSET:
            field_dict["calibration"] = calibration
        if depth_mm is not UNSET:
            field_dict["depth_mm"] = depth_mm
        if noise_sigma is not UNSET:
            field_dict["noise_sigma"] = noise_sigma

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.depth_map_body_flags import DepthMapBodyFlags
        from ..models.depth_span_body import DepthSpanBody
        from ..models.depth_timings import DepthTimings
        from ..models.header_echo import HeaderEcho

        d = dict(src_dict)
        header = HeaderEcho.from_dict(d.pop("header"))

        method = check_depth_method_word(d.pop("method"))

        def _parse_window(data: object) -> AutoWord | float:
            try:
                if not isinstance(data, str):
                    raise TypeError()
                componentsschemas_window_body_type_1 = check_auto_word(data)

                return componentsschemas_window_body_type_1
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(AutoWord | float, data)

        window = _parse_window(d.pop("window"))

        width_px = d.pop("width_px")

        height_px = d.pop("height_px")

        near_focus_mm = d.pop("near_focus_mm")

        far_focus_mm = d.pop("far_focus_mm")

        range_mm = d.pop("range_mm")

        largest_blur_px = d.pop("largest_blur_px")

        coverage = d.pop("coverage")

        shift_px = cast(list[float], d.pop("shift_px"))

        gain = d.pop("gain")

        flags = DepthMapBodyFlags.from_dict(d.pop("flags"))

        warnings = cast(list[str], d.pop("warnings"))

        timings_ms = DepthTimings.from_dict(d.pop("timings_ms"))

        def _parse_calibration(data: object) -> None | str | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(None | str | Unset, data)

        calibration = _parse_calibration(d.pop("calibration", UNSET))

        def _parse_depth_mm(data: object) -> DepthSpanBody | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                depth_mm_type_0 = DepthSpanBody.from_dict(data)

                return depth_mm_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            return cast(DepthSpanBody | None | Unset, data)

        depth_mm = _parse_depth_mm(d.pop("depth_mm", UNSET))

        def _parse_noise_sigma(data: object) -> float | None | Unset:
            if data is None:
                return data
            if isinstance(data, Unset):
                return data
            return cast(float | None | Unset, data)

        noise_sigma = _parse_noise_sigma(d.pop("noise_sigma", UNSET))

        depth_map_body = cls(
            header=header,
            method=method,
            window=window,
            width_px=width_px,
            height_px=height_px,
            near_focus_mm=near_focus_mm,
            far_focus_mm=far_focus_mm,
            range_mm=range_mm,
            largest_blur_px=largest_blur_px,
            coverage=coverage,
            shift_px=shift_px,
            gain=gain,
            flags=flags,
            warnings=warnings,
            timings_ms=timings_ms,
            calibration=calibration,
            depth_mm=depth_mm,
            noise_sigma=noise_sigma,
        )

        depth_map_body.additional_properties = d
        return depth_map_body

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
