from typing import Literal, cast

DepthMethodWord = Literal["gram", "laplacian", "stm"]

DEPTH_METHOD_WORD_VALUES: set[DepthMethodWord] = {
    "gram",
    "laplacian",
    "stm",
}


def check_depth_method_word(value: str) -> DepthMethodWord:
    if value in DEPTH_METHOD_WORD_VALUES:
        return cast(DepthMethodWord, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {DEPTH_METHOD_WORD_VALUES!r}")
