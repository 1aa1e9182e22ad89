from typing import Literal, cast

ObjectRecognitionBodyKind = Literal["objects"]

OBJECT_RECOGNITION_BODY_KIND_VALUES: set[ObjectRecognitionBodyKind] = {
    "objects",
}


def check_object_recognition_body_kind(value: str) -> ObjectRecognitionBodyKind:
    if value in OBJECT_RECOGNITION_BODY_KIND_VALUES:
        return cast(ObjectRecognitionBodyKind, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {OBJECT_RECOGNITION_BODY_KIND_VALUES!r}")
