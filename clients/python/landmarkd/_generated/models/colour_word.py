from typing import Literal, cast

ColourWord = Literal["auto", "gray", "opponent"]

COLOUR_WORD_VALUES: set[ColourWord] = {
    "auto",
    "gray",
    "opponent",
}


def check_colour_word(value: str) -> ColourWord:
    if value in COLOUR_WORD_VALUES:
        return cast(ColourWord, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {COLOUR_WORD_VALUES!r}")
