from typing import Literal, cast

ItemStatus = Literal["created", "duplicate", "rejected"]

ITEM_STATUS_VALUES: set[ItemStatus] = {
    "created",
    "duplicate",
    "rejected",
}


def check_item_status(value: str) -> ItemStatus:
    if value in ITEM_STATUS_VALUES:
        return cast(ItemStatus, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {ITEM_STATUS_VALUES!r}")
