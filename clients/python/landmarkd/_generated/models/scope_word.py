from typing import Literal, cast

ScopeWord = Literal["admin", "contribute", "recognise", "train"]

SCOPE_WORD_VALUES: set[ScopeWord] = {
    "admin",
    "contribute",
    "recognise",
    "train",
}


def check_scope_word(value: str) -> ScopeWord:
    if value in SCOPE_WORD_VALUES:
        return cast(ScopeWord, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {SCOPE_WORD_VALUES!r}")
