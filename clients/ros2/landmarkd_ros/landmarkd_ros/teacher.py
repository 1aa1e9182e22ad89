"""The services: ~/teach shows the service the picture of now, ~/train makes a version of all that was taught.

Both are `std_srvs/Trigger`: what a picture is called is the parameter `label`, so that a button teaches while a robot
is driven through a room, and no package of interfaces has to be built. A failure is `success: false` with the reason.
"""

from __future__ import annotations

import time
from typing import Any

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from std_srvs.srv import Trigger

from landmarkd import Client, JobFailed, MapPose, Problem, Unreachable

from . import images, planar
from .recogniser import Recogniser
from .transforms import Transforms

FRESH_S = 2.0
"""A picture older than this isn't what the camera sees now."""


class Teacher:
    """Teaches and trains."""

    def __init__(self, node: Any, client: Client, recogniser: Recogniser, transforms: Transforms) -> None:
        self.node = node
        self.client = client
        self.recogniser = recogniser
        self.transforms = transforms
        # In groups of their own: they wait for the service, pictures don't wait for them.
        self._services = [
            node.create_service(Trigger, name, answer, callback_group=MutuallyExclusiveCallbackGroup())
            for name, answer in (("~/teach", self._teach), ("~/train", self._train))
        ]

    def _teach(self, request: Any, response: Any) -> Any:
        """Teach the last picture, with the camera's pose in the map if tf knows it."""
        label = self.node.get_parameter("label").value
        seen = self.recogniser.latest
        if not label:
            return said(response, False, "the parameter label is empty: set it to the place's name")
        if seen is None or time.monotonic() - seen.came_s > FRESH_S:
            return said(response, False, f"no picture came in the last {FRESH_S:.0f} s")
        header = seen.message.header
        pose = self._pose(header)
        taken = images.stamp(header.stamp)
        try:
            exemplar = self.client.teach(
                self.node.get_parameter("database").value,
                label,
                images.picture(seen.message),
                pose=pose,
                camera=self.recogniser.camera(),
                frame_id=f"{header.frame_id}:{taken}",
                stamp=taken,
            )
        except (Problem, Unreachable, ValueError) as fault:
            return said(response, False, str(fault))
        where = (
            "without a pose: tf doesn't know one"
            if pose is None
            else f"at x {pose.x_m:.2f} m, y {pose.y_m:.2f} m, yaw {pose.yaw_deg:.1f}°"
        )
        return said(response, True, f"{label}: exemplar {exemplar.id}, {where}; ~/train brings it into force")

    def _pose(self, header: Any) -> MapPose | None:
        """The pose of the camera's body in the map at the picture's stamp."""
        frame = self.node.get_parameter("map_frame").value
        transform = self.transforms.at(frame, header.frame_id, header.stamp)
        if transform is None:
            return None
        yaw_deg, pitch_deg, roll_deg = planar.angles_deg(transform)
        at = transform.translation
        return MapPose(frame.replace("/", "_"), at.x, at.y, yaw_deg, at.z, pitch_deg, roll_deg)

    def _train(self, request: Any, response: Any) -> Any:
        """Train, and answer when it has ended."""
        try:
            job = self.client.train(
                self.node.get_parameter("database").value, promote=self.node.get_parameter("promote").value
            )
        except (Problem, Unreachable, JobFailed) as fault:
            return said(response, False, str(fault))
        return said(response, True, f"version {job.version}")

    def close(self) -> None:
        """Offer them no more."""
        for service in self._services:
            self.node.destroy_service(service)


def said(response: Any, success: bool, message: str) -> Any:
    """A `Trigger` response."""
    response.success, response.message = success, message
    return response
