from typing import Literal, cast

ReadyStatus = Literal["degraded", "ready", "starting"]

READY_STATUS_VALUES: set[ReadyStatus] = {
    "degraded",
    "ready",
    "starting",
}


def check_ready_status(value: str) -> ReadyStatus:
    if value in READY_STATUS_VALUES:
        return cast(ReadyStatus, value)
    raise TypeError(f"Unexpected value {value!r}. Expected one of {READY_STATUS_VALUES!r}")
