from typing import Literal, cast

StateWord = Literal["cancelled", "failed", "queued", "running", "succeeded"]

STATE_WORD_VALUES: set[StateWord] = {
    "cancelled",
    "failed",
    "queued",
    "running",
    "succeeded",
}


def check_state_word(value: str) -> StateWord:
    if value in STATE_WORD_VALUES:
        return cast(StateWord, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {STATE_WORD_VALUES!r}")
