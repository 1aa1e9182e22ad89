from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, cast

from attrs import define as _attrs_define
from attrs import field as _attrs_field

from ..models.mapping_kind_word import MappingKindWord, check_mapping_kind_word

T = TypeVar("T", bound="MappingBody")


@_attrs_define
class MappingBody:
    """From the overview camera's pixels to the robot."""

    kind: MappingKindWord
    """ What a mapping keeps: shapes (turned, scaled and moved); parallels; straight lines (a camera that looks
    aslant). """
    matrix: list[list[float]]
    """ Row by row: (X·w, Y·w, w) = matrix · (x, y, 1), in mm and pixels. """
    residual_mm: float
    """ Root mean square distance of the correspondences from where the mapping puts them. """
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        kind: str = self.kind

        matrix = []
        for matrix_item_data in self.matrix:
            matrix_item = matrix_item_data

            matrix.append(matrix_item)

        residual_mm = self.residual_mm

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "kind": kind,
                "matrix": matrix,
                "residual_mm": residual_mm,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        d = dict(src_dict)
        kind = check_mapping_kind_word(d.pop("kind"))

        matrix = []
        _matrix = d.pop("matrix")
        for matrix_item_data in _matrix:
            matrix_item = cast(list[float], matrix_item_data)

            matrix.append(matrix_item)

        residual_mm = d.pop("residual_mm")

        mapping_body = cls(
            kind=kind,
            matrix=matrix,
            residual_mm=residual_mm,
        )

        mapping_body.additional_properties = d
        return mapping_body

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
