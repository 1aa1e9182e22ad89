from typing import Literal, cast

InspectPairView = Literal["local", "overview"]

INSPECT_PAIR_VIEW_VALUES: set[InspectPairView] = {
    "local",
    "overview",
}


def check_inspect_pair_view(value: str) -> InspectPairView:
    if value in INSPECT_PAIR_VIEW_VALUES:
        return cast(InspectPairView, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {INSPECT_PAIR_VIEW_VALUES!r}")
