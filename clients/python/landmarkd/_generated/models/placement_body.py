from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

T = TypeVar("T", bound="PlacementBody")


@_attrs_define
class PlacementBody:
    """An exemplar laid on the frame."""

    x_px: float
    """ Where the centre of the exemplar's picture is seen. """
    y_px: float
    rotation_deg: float
    """ How it is turned, in (-180, 180]; positive from x towards y: clockwise as seen on screen. """
    scale: float
    """ Pixels of the frame for each of the exemplar. """
    inliers: int
    """ Sub-windows of the frame that agree on it. """
    agreement: float
    """ How well the exemplar's gradients are found again in the frame, -1 to 1. """
    outline_px: list[list[float]]
    """ The corners of the exemplar's picture on the frame, from its top left on clockwise. """
    exemplar: str
    """ Id of the exemplar. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        x_px = self.x_px

        y_px = self.y_px

        rotation_deg = self.rotation_deg

        scale = self.scale

        inliers = self.inliers

        agreement = self.agreement

        outline_px = []
        for outline_px_item_data in self.outline_px:
            outline_px_item = outline_px_item_data

            outline_px.append(outline_px_item)

        exemplar = self.exemplar

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "x_px": x_px,
                "y_px": y_px,
                "rotation_deg": rotation_deg,
                "scale": scale,
                "inliers": inliers,
                "agreement": agreement,
                "outline_px": outline_px,
                "exemplar": exemplar,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        x_px = d.pop("x_px")

        y_px = d.pop("y_px")

        rotation_deg = d.pop("rotation_deg")

        scale = d.pop("scale")

        inliers = d.pop("inliers")

        agreement = d.pop("agreement")

        outline_px = []
        _outline_px = d.pop("outline_px")
        for outline_px_item_data in _outline_px:
            outline_px_item = cast(list[float], outline_px_item_data)

            outline_px.append(outline_px_item)

        exemplar = d.pop("exemplar")

        placement_body = cls(
            x_px=x_px,
            y_px=y_px,
            rotation_deg=rotation_deg,
            scale=scale,
            inliers=inliers,
            agreement=agreement,
            outline_px=outline_px,
            exemplar=exemplar,
        )

        placement_body.additional_properties = d
        return placement_body

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
