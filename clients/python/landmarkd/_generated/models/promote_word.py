from typing import Literal, cast

PromoteWord = Literal["always", "if_not_worse", "never"]

PROMOTE_WORD_VALUES: set[PromoteWord] = {
    "always",
    "if_not_worse",
    "never",
}


def check_promote_word(value: str) -> PromoteWord:
    if value in PROMOTE_WORD_VALUES:
        return cast(PromoteWord, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {PROMOTE_WORD_VALUES!r}")
