from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from attrs import define as _attrs_define
from attrs import field as _attrs_field

if TYPE_CHECKING:
    from ..models.landmark_recognition_body import LandmarkRecognitionBody
    from ..models.object_recognition_body import ObjectRecognitionBody
    from ..models.recognition_item_type_1 import RecognitionItemType1


T = TypeVar("T", bound="RecognitionBatch")


@_attrs_define
class RecognitionBatch:
    """The answers to a batch, in the order of its pictures."""

    items: list[LandmarkRecognitionBody | ObjectRecognitionBody | RecognitionItemType1]
    additional_properties: dict[str, Any] = _attrs_field(init=False, factory=dict)

    def to_dict(self) -> dict[str, Any]:
        from ..models.landmark_recognition_body import LandmarkRecognitionBody
        from ..models.object_recognition_body import ObjectRecognitionBody

        items = []
        for items_item_data in self.items:
            items_item: dict[str, Any]
            if isinstance(items_item_data, LandmarkRecognitionBody):
                items_item = items_item_data.to_dict()
            elif isinstance(items_item_data, ObjectRecognitionBody):
                items_item = items_item_data.to_dict()
            else:
                items_item = items_item_data.to_dict()

            items.append(items_item)

        field_dict: dict[str, Any] = {}
        field_dict.update(self.additional_properties)
        field_dict.update(
            {
                "items": items,
            }
        )

        return field_dict

    @classmethod
    def from_dict(cls: type[T], src_dict: Mapping[str, Any]) -> T:
        from ..models.landmark_recognition_body import LandmarkRecognitionBody
        from ..models.object_recognition_body import ObjectRecognitionBody
        from ..models.recognition_item_type_1 import RecognitionItemType1

        d = dict(src_dict)
        items = []
        _items = d.pop("items")
        for items_item_data in _items:

            def _parse_items_item(
                data: object,
            ) -> LandmarkRecognitionBody | ObjectRecognitionBody | RecognitionItemType1:
                try:
                    if not isinstance(data, dict):
                        raise TypeError()
                    componentsschemas_recognition_body_type_0 = LandmarkRecognitionBody.from_dict(data)

                    return componentsschemas_recognition_body_type_0
                except (TypeError, ValueError, AttributeError, KeyError):
                    pass
                try:
                    if not isinstance(data, dict):
                        raise TypeError()
                    componentsschemas_recognition_body_type_1 = ObjectRecognitionBody.from_dict(data)

                    return componentsschemas_recognition_body_type_1
                except (TypeError, ValueError, AttributeError, KeyError):
                    pass
                if not isinstance(data, dict):
                    raise TypeError()
                componentsschemas_recognition_item_type_1 = RecognitionItemType1.from_dict(data)

                return componentsschemas_recognition_item_type_1

            items_item = _parse_items_item(items_item_data)

            items.append(items_item)

        recognition_batch = cls(
            items=items,
        )

        recognition_batch.additional_properties = d
        return recognition_batch

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
