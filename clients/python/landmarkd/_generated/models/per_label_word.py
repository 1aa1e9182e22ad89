from typing import Literal, cast

PerLabelWord = Literal["best", "sum"]

PER_LABEL_WORD_VALUES: set[PerLabelWord] = {
    "best",
    "sum",
}


def check_per_label_word(value: str) -> PerLabelWord:
    if value in PER_LABEL_WORD_VALUES:
        return cast(PerLabelWord, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {PER_LABEL_WORD_VALUES!r}")
