from typing import Literal, cast

StagesWord = Literal["universal_only", "universal_then_object"]

STAGES_WORD_VALUES: set[StagesWord] = {
    "universal_only",
    "universal_then_object",
}


def check_stages_word(value: str) -> StagesWord:
    if value in STAGES_WORD_VALUES:
        return cast(StagesWord, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {STAGES_WORD_VALUES!r}")
