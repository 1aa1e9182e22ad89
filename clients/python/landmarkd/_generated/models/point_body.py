from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from attrs import define as _attrs_define
from attrs import field as _attrs_field

T = TypeVar("T", bound="PointBody")


@_attrs_define
class PointBody:
    """The vote of an interest point."""

    x_px: float
    y_px: float
    salience: float
    exemplar: str
    """ Id of the exemplar that it votes for, or whose eigenpoint is nearest. """
    label: str
    """ Its label. """
    distance: float
    """ Distance D in the eigenspace. """
    weight: float
    """ Its part of W: 0 where it counts for nothing; with the paper's method 1/(D+ε). """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        x_px = self.x_px

        y_px = self.y_px

        salience = self.salience

        exemplar = self.exemplar

        label = self.label

        distance = self.distance

        weight = self.weight

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "x_px": x_px,
                "y_px": y_px,
                "salience": salience,
                "exemplar": exemplar,
                "label": label,
                "distance": distance,
                "weight": weight,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        x_px = d.pop("x_px")

        y_px = d.pop("y_px")

        salience = d.pop("salience")

        exemplar = d.pop("exemplar")

        label = d.pop("label")

        distance = d.pop("distance")

        weight = d.pop("weight")

        point_body = cls(
            x_px=x_px,
            y_px=y_px,
            salience=salience,
            exemplar=exemplar,
            label=label,
            distance=distance,
            weight=weight,
        )

        point_body.additional_properties = d
        return point_body

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
