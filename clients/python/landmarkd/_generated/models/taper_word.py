from typing import Literal, cast

TaperWord = Literal["literal", "radial"]

TAPER_WORD_VALUES: set[TaperWord] = {
    "literal",
    "radial",
}


def check_taper_word(value: str) -> TaperWord:
    if value in TAPER_WORD_VALUES:
        return cast(TaperWord, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {TAPER_WORD_VALUES!r}")
