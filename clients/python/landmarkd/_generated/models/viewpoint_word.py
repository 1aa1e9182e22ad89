from typing import Literal, cast

ViewpointWord = Literal["free", "upright"]

VIEWPOINT_WORD_VALUES: set[ViewpointWord] = {
    "free",
    "upright",
}


def check_viewpoint_word(value: str) -> ViewpointWord:
    if value in VIEWPOINT_WORD_VALUES:
        return cast(ViewpointWord, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {VIEWPOINT_WORD_VALUES!r}")
