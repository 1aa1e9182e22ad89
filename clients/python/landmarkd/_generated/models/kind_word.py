from typing import Literal, cast

KindWord = Literal["landmarks", "objects"]

KIND_WORD_VALUES: set[KindWord] = {
    "landmarks",
    "objects",
}


def check_kind_word(value: str) -> KindWord:
    if value in KIND_WORD_VALUES:
        return cast(KindWord, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {KIND_WORD_VALUES!r}")
