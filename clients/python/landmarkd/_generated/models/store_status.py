from typing import Literal, cast

StoreStatus = Literal["ok", "unavailable"]

STORE_STATUS_VALUES: set[StoreStatus] = {
    "ok",
    "unavailable",
}


def check_store_status(value: str) -> StoreStatus:
    if value in STORE_STATUS_VALUES:
        return cast(StoreStatus, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {STORE_STATUS_VALUES!r}")
