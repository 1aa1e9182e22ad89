from typing import Literal, cast

OperatorWord = Literal["harris", "symmetry"]

OPERATOR_WORD_VALUES: set[OperatorWord] = {
    "harris",
    "symmetry",
}


def check_operator_word(value: str) -> OperatorWord:
    if value in OPERATOR_WORD_VALUES:
        return cast(OperatorWord, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {OPERATOR_WORD_VALUES!r}")
