"""Where the robot is in the map: the pose, what Nav2 starts from, and tf.

The service tells the pose of the camera's body in the map. That of the base is one transform of tf away, and tf's
map→odom is what brings the odometry's pose of the base to it: `T_map_odom = T_map_base · T_odom_base⁻¹`, at the
picture's stamp.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseWithCovarianceStamped
from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from tf2_ros import TransformBroadcaster

from landmarkd import PlacePose
from landmarkd.planar import Planar, carried

from . import messages, planar
from .transforms import Transforms

LATCHED = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Those who come later get the last one."""
TF_PERIOD_S = 0.05
TF_AHEAD_S = 0.1
"""map→odom hardly changes, so it is said a little ahead: whoever asks about now finds it, as with AMCL."""


class Localisation:
    """Publishes poses."""

    def __init__(self, node: Any, transforms: Transforms) -> None:
        self.node = node
        self.transforms = transforms
        self.lost = True
        """Whether the next pose is the first one known."""
        self._map_odom: Planar | None = None
        self._pose = node.create_lifecycle_publisher(PoseWithCovarianceStamped, "pose", LATCHED)
        self._initial = node.create_lifecycle_publisher(PoseWithCovarianceStamped, "/initialpose", 1)
        self._broadcaster = TransformBroadcaster(node)
        self._timer = node.create_timer(TF_PERIOD_S, self._say_again)

    def begin(self) -> None:
        """Know nothing: the node was activated, or ends."""
        self.lost, self._map_odom = True, None

    def publish(self, pose: PlacePose | None, header: Any) -> None:
        """Publish the pose of an answer. One that is lost isn't published: it would be driven by."""
        if pose is None:
            return
        if pose.lost:
            self.begin()
            return
        found = self._of_base(pose, header)
        if found is None:
            return
        base, covariance = found
        frame = self.node.get_parameter("map_frame").value
        stamped = messages.pose_stamped(base, covariance, frame, header.stamp)
        self._pose.publish(stamped)
        if self.lost and self.node.get_parameter("initialpose").value:
            self._initial.publish(stamped)
        self.lost = False
        if self.node.get_parameter("publish_tf").value:
            self._broadcast(base, frame, header)

    def _of_base(self, pose: PlacePose, header: Any) -> tuple[Planar, Any] | None:
        """The pose that is published, with its covariance; `None` while tf doesn't know where the camera is mounted."""
        seen = Planar(pose.x_m, pose.y_m, math.radians(pose.yaw_deg))
        covariance = np.array(pose.covariance, float).reshape(3, 3)
        base_frame = self.node.get_parameter("base_frame").value
        if not base_frame:
            return seen, covariance
        mounted = self.transforms.at(base_frame, header.frame_id, header.stamp)
        base_camera = planar.camera(mounted) if mounted is not None else None
        if base_camera is None:
            self.node.get_logger().warning(
                f"no pose: tf doesn't know a level view of {header.frame_id!r} in {base_frame!r}",
                throttle_duration_sec=10,
            )
            return None
        return carried(seen, covariance, base_camera)

    def _broadcast(self, base: Planar, frame: str, header: Any) -> None:
        """Broadcast map→odom, now and until the next; without odometry, map→base once."""
        base_frame = self.node.get_parameter("base_frame").value
        odom_frame = self.node.get_parameter("odom_frame").value
        if not odom_frame:
            # Without a base_frame it is the camera's body, beside its optical frame.
            child = base_frame or f"{header.frame_id}_body"
            self._broadcaster.sendTransform(messages.transform_stamped(base, frame, child, header.stamp))
            return
        # The camera's heading is taken if no base is named.
        moved = self.transforms.at(odom_frame, base_frame or header.frame_id, header.stamp)
        odom_base = None if moved is None else (planar.body if base_frame else planar.camera)(moved)
        if odom_base is None:
            self.node.get_logger().warning(
                f"no {frame}→{odom_frame}: tf doesn't know {odom_frame!r} at the picture's stamp",
                throttle_duration_sec=10,
            )
            return
        self._map_odom = base @ odom_base.inverse
        self._say_again()

    def _say_again(self) -> None:
        """Broadcast the last map→odom."""
        if self._map_odom is None or not self.node.get_parameter("publish_tf").value:
            return
        stamp = (self.node.get_clock().now() + Duration(seconds=TF_AHEAD_S)).to_msg()
        frame, child = (self.node.get_parameter(name).value for name in ("map_frame", "odom_frame"))
        self._broadcaster.sendTransform(messages.transform_stamped(self._map_odom, frame, child, stamp))

    def close(self) -> None:
        """Publish no more."""
        self.begin()
        self.node.destroy_timer(self._timer)
        self.node.destroy_publisher(self._broadcaster.pub_tf)
        for publisher in (self._pose, self._initial):
            self.node.destroy_lifecycle_publisher(publisher)
