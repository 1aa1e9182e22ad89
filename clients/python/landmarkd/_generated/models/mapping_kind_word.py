from typing import Literal, cast

MappingKindWord = Literal["affine", "homography", "similarity"]

MAPPING_KIND_WORD_VALUES: set[MappingKindWord] = {
    "affine",
    "homography",
    "similarity",
}


def check_mapping_kind_word(value: str) -> MappingKindWord:
    if value in MAPPING_KIND_WORD_VALUES:
        return cast(MappingKindWord, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {MAPPING_KIND_WORD_VALUES!r}")
