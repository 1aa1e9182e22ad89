from typing import Literal, cast

MethodWord = Literal["paper", "placement"]

METHOD_WORD_VALUES: set[MethodWord] = {
    "paper",
    "placement",
}


def check_method_word(value: str) -> MethodWord:
    if value in METHOD_WORD_VALUES:
        return cast(MethodWord, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {METHOD_WORD_VALUES!r}")
