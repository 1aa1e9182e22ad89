from typing import Literal, cast

AutoOrNoneWord = Literal["auto", "none"]

AUTO_OR_NONE_WORD_VALUES: set[AutoOrNoneWord] = {
    "auto",
    "none",
}


def check_auto_or_none_word(value: str) -> AutoOrNoneWord:
    if value in AUTO_OR_NONE_WORD_VALUES:
        return cast(AutoOrNoneWord, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {AUTO_OR_NONE_WORD_VALUES!r}")
