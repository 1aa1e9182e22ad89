from typing import Literal, cast

ThresholdWord = Literal["adaptive", "otsu"]

THRESHOLD_WORD_VALUES: set[ThresholdWord] = {
    "adaptive",
    "otsu",
}


def check_threshold_word(value: str) -> ThresholdWord:
    if value in THRESHOLD_WORD_VALUES:
        return cast(ThresholdWord, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {THRESHOLD_WORD_VALUES!r}")
