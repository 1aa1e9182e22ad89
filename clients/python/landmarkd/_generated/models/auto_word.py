from typing import Literal, cast

AutoWord = Literal["auto"]

AUTO_WORD_VALUES: set[AutoWord] = {
    "auto",
}


def check_auto_word(value: str) -> AutoWord:
    if value in AUTO_WORD_VALUES:
        return cast(AutoWord, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {AUTO_WORD_VALUES!r}")
