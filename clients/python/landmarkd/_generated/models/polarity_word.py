from typing import Literal, cast

PolarityWord = Literal["dark_on_light", "light_on_dark"]

POLARITY_WORD_VALUES: set[PolarityWord] = {
    "dark_on_light",
    "light_on_dark",
}


def check_polarity_word(value: str) -> PolarityWord:
    if value in POLARITY_WORD_VALUES:
        return cast(PolarityWord, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {POLARITY_WORD_VALUES!r}")
