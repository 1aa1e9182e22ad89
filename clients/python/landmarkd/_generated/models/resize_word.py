from typing import Literal, cast

ResizeWord = Literal["fit", "never"]

RESIZE_WORD_VALUES: set[ResizeWord] = {
    "fit",
    "never",
}


def check_resize_word(value: str) -> ResizeWord:
    if value in RESIZE_WORD_VALUES:
        return cast(ResizeWord, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {RESIZE_WORD_VALUES!r}")
