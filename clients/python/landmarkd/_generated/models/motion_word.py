from typing import Literal, cast

MotionWord = Literal["auto", "path", "still"]

MOTION_WORD_VALUES: set[MotionWord] = {
    "auto",
    "path",
    "still",
}


def check_motion_word(value: str) -> MotionWord:
    if value in MOTION_WORD_VALUES:
        return cast(MotionWord, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {MOTION_WORD_VALUES!r}")
