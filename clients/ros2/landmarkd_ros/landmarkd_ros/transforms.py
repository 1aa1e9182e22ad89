"""What tf knows about the camera, the robot and its odometry."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import Transform
from rclpy.duration import Duration
from rclpy.time import Time
from tf2_ros import Buffer, TransformException, TransformListener

WAIT_S = 0.1
"""Longest wait for a transform: odometry comes a little after the picture."""


class Transforms:
    """The tree of transforms, listened to."""

    def __init__(self, node: Any) -> None:
        self._buffer = Buffer()
        self._listener = TransformListener(self._buffer, node)

    def at(self, target: str, source: str, stamp: Any) -> Transform | None:
        """`T_target_source` at a stamp; `None` if tf doesn't know it. Waits only for frames that it knows."""
        try:
            if not self._buffer.can_transform(target, source, Time()):
                return None
            return self._buffer.lookup_transform(
                target, source, Time.from_msg(stamp), timeout=Duration(seconds=WAIT_S)
            ).transform
        except TransformException:
            return None

    def close(self) -> None:
        """Listen no more."""
        self._listener.unregister()
