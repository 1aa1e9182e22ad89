"""The node: pictures in; places, poses, things and distances out.

    in   image                sensor_msgs/Image           asked about; the newest wins
         image/compressed     CompressedImage             the same, passed through
         camera_info          CameraInfo                  sent with the pictures
         tf                   odom → camera, base → camera; map → camera for teaching
         near, far            Image                       a focal pair, with the parameter `calibration`
         near/camera_info     CameraInfo                  passed through beside the distances
    out  place                vision_msgs/Classification  where the robot is, by all frames so far
         decision             Classification              what to act on; empty when nothing is sure enough
         detections           Detection2DArray            what is in the frame, where, and its pose
         pose, /initialpose   PoseWithCovarianceStamped   where the base is in the map
         tf                   map → odom, or map → base
         depth/image          Image                       32FC1, metres along the optical axis, NaN unknown
         depth/camera_info    CameraInfo                  the near camera's
         /diagnostics         DiagnosticArray             how it does
    do   ~/teach, ~/train     std_srvs/Trigger

Configured it listens, active it asks and publishes. Calls to the service are made by threads of their own.
"""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import Any

import rclpy
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn

from landmarkd import Client
from landmarkd.kept_version import KeptVersion
from landmarkd.robot import Robot
from landmarkd.stand_in import StandIn

from . import parameters
from .distances import Distances
from .health import Health
from .localisation import Localisation
from .recogniser import Recogniser
from .teacher import Teacher
from .transforms import Transforms


class LandmarkdNode(LifecycleNode):  # type: ignore[misc]
    """Asks the service about what the camera sees."""

    def __init__(self) -> None:
        super().__init__("landmarkd")
        self.configured = False
        self.active = False
        self._parts = ExitStack()
        parameters.declare(self)

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Make what the parameters say."""
        try:
            self._configure()
        except Exception as fault:
            # rclpy would say nothing.
            self.get_logger().error(f"can't be configured: {fault}")
            self._take_down()
            return TransitionCallbackReturn.FAILURE
        self.configured = True
        return TransitionCallbackReturn.SUCCESS

    def _configure(self) -> None:
        asked = {name: self.get_parameter(name).value for name in parameters.PARAMETERS}
        if asked["local_binary"] and not asked["keep"]:
            raise ValueError("local_binary needs keep: it answers from what is kept there")
        client = self._parts.enter_context(
            Client(asked["service"], robot_id=asked["robot_id"] or None, timeout_s=asked["timeout_s"])
        )
        keep = Path(asked["keep"]) if asked["keep"] else None
        robot = Robot(
            client,
            asked["database"],
            tracked=asked["tracked"],
            motion=asked["motion"],
            kept=KeptVersion(keep / "version") if keep else None,
            stand_in=StandIn(Path(asked["local_binary"]), keep / "data") if keep and asked["local_binary"] else None,
        )
        transforms = self._closed(Transforms(self))
        self.health = self._closed(Health(self, asked["service"]))
        self.localisation = self._closed(Localisation(self, transforms))
        self.recogniser = self._closed(Recogniser(self, client, robot, transforms, self.localisation, self.health))
        self._closed(Teacher(self, client, self.recogniser, transforms))
        if asked["calibration"]:
            self.distances = self._closed(Distances(self, client, asked["calibration"]))

    def _closed(self, part: Any) -> Any:
        """A part that is closed at the end, before those that it was made with."""
        self._parts.callback(part.close)
        return part

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Ask from now on."""
        self.localisation.begin()
        self.recogniser.begin()
        done = super().on_activate(state)
        self.active = done == TransitionCallbackReturn.SUCCESS
        return done

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Ask no more."""
        self.active = False
        self.localisation.begin()
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Take down what was configured."""
        self._take_down()
        return TransitionCallbackReturn.SUCCESS

    on_shutdown = on_error = on_cleanup

    def _take_down(self) -> None:
        """End threads, the track, and the local service if one runs."""
        self.active = self.configured = False
        self._parts.close()

    def destroy_node(self) -> None:
        """End with all that was configured."""
        self._take_down()
        super().destroy_node()


def main(words: list[str] | None = None) -> None:
    """Run the node until it is shut down."""
    rclpy.init(args=words)
    node = LandmarkdNode()
    executor = MultiThreadedExecutor(num_threads=4)
    executor.add_node(node)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
