from typing import Literal, cast

DistanceWord = Literal["euclidean", "mahalanobis"]

DISTANCE_WORD_VALUES: set[DistanceWord] = {
    "euclidean",
    "mahalanobis",
}


def check_distance_word(value: str) -> DistanceWord:
    if value in DISTANCE_WORD_VALUES:
        return cast(DistanceWord, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {DISTANCE_WORD_VALUES!r}")
