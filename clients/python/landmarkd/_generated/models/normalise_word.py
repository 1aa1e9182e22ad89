from typing import Literal, cast

NormaliseWord = Literal["contrast", "energy", "none"]

NORMALISE_WORD_VALUES: set[NormaliseWord] = {
    "contrast",
    "energy",
    "none",
}


def check_normalise_word(value: str) -> NormaliseWord:
    if value in NORMALISE_WORD_VALUES:
        return cast(NormaliseWord, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {NORMALISE_WORD_VALUES!r}")
