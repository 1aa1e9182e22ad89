from typing import Literal, cast

SearchWord = Literal["exhaustive", "kd_tree", "slabs"]

SEARCH_WORD_VALUES: set[SearchWord] = {
    "exhaustive",
    "kd_tree",
    "slabs",
}


def check_search_word(value: str) -> SearchWord:
    if value in SEARCH_WORD_VALUES:
        return cast(SearchWord, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {SEARCH_WORD_VALUES!r}")
