from typing import Literal, cast

LandmarkRecognitionBodyKind = Literal["landmarks"]

LANDMARK_RECOGNITION_BODY_KIND_VALUES: set[LandmarkRecognitionBodyKind] = {
    "landmarks",
}


def check_landmark_recognition_body_kind(value: str) -> LandmarkRecognitionBodyKind:
    if value in LANDMARK_RECOGNITION_BODY_KIND_VALUES:
        return cast(LandmarkRecognitionBodyKind, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {LANDMARK_RECOGNITION_BODY_KIND_VALUES!r}")
