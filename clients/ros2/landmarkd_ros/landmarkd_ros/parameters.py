"""The node's parameters: defaults, descriptions, ranges, and which may be changed while it runs.

Those that may are read where they are used, each time; the others when the node is configured.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult


@dataclass(frozen=True)
class Parameter:
    """A parameter with its default and what it is for."""

    default: bool | float | str
    what: str
    at_run_time: bool = False
    """Whether a change counts at once."""
    range: tuple[float, float] | None = None
    """Of a number."""
    choices: tuple[str, ...] = ()
    """Of a word; any if there are none."""


PARAMETERS = {
    "service": Parameter(
        "http://127.0.0.1:8080", "Address of the service; its key is LANDMARKD_KEY of the environment."
    ),
    "database": Parameter("home", "Which places or objects are asked about, and taught."),
    "image_transport": Parameter(
        "raw",
        "raw: sensor_msgs/Image on `image`; compressed: sensor_msgs/CompressedImage on `image/compressed`, whose bytes "
        "go to the service as they are.",
        choices=("raw", "compressed"),
    ),
    "rectified": Parameter(False, "The pictures have no distortion any more: CameraInfo's P counts, not K and D."),
    "tracked": Parameter(True, "A track of the service adds frames up; false asks about each alone."),
    "motion": Parameter("auto", "How a track takes the robot to move.", choices=("auto", "path", "still")),
    "robot_id": Parameter("", "Who asks; the service's answers and records have it."),
    "timeout_s": Parameter(5.0, "Longest wait for an answer, in seconds.", range=(0.1, 600.0)),
    "max_rate_hz": Parameter(
        0.0,
        "Frames asked about a second at most; 0 asks as fast as answers come.",
        at_run_time=True,
        range=(0.0, 1000.0),
    ),
    "map_frame": Parameter("map", "Frame of the poses that exemplars are taught with."),
    "base_frame": Parameter(
        "base_link", "Frame whose pose is published, found by tf from the picture's; empty: the camera's own body."
    ),
    "odom_frame": Parameter(
        "odom", "Frame of tf's odometry, sent with the frames of a track; empty: the robot has none."
    ),
    "publish_tf": Parameter(
        False, "Whether map→odom is broadcast, or map→base without an odom_frame.", at_run_time=True
    ),
    "initialpose": Parameter(
        False,
        "Whether the first pose after activation, and the first after the track was lost, goes to /initialpose too.",
        at_run_time=True,
    ),
    "label": Parameter("", "What the service ~/teach calls the picture.", at_run_time=True),
    "promote": Parameter(
        "if_not_worse",
        "Whether the version that ~/train makes is used from then on.",
        at_run_time=True,
        choices=("always", "if_not_worse", "never"),
    ),
    "keep": Parameter("", "Folder that the version in use is kept in; empty keeps none."),
    "local_binary": Parameter(
        "", "landmarkd, which answers from `keep` while the service is away; empty: nobody does."
    ),
    "calibration": Parameter("", "The service's calibration for distances from `near` and `far`; empty measures none."),
    "pair_slop_s": Parameter(
        0.02, "The two pictures of a pair were taken at most so far apart, in seconds.", range=(0.0, 10.0)
    ),
}


def descriptor(parameter: Parameter) -> Any:
    """What `ros2 param describe` shows."""
    shown = ParameterDescriptor()
    shown.description = parameter.what
    constraints = []
    if parameter.choices:
        constraints.append("one of " + ", ".join(parameter.choices))
    if not parameter.at_run_time:
        constraints.append("fixed while the node is configured")
    shown.additional_constraints = "; ".join(constraints)
    if parameter.range is not None:
        bounds = FloatingPointRange()
        bounds.from_value, bounds.to_value = parameter.range
        shown.floating_point_range = [bounds]
    return shown


def declare(node: Any) -> None:
    """Declare all of them. Values that can't be are refused, those that the node is started with too."""
    node.add_on_set_parameters_callback(lambda changes: judged(changes, node.configured))
    for name, parameter in PARAMETERS.items():
        node.declare_parameter(name, parameter.default, descriptor(parameter))


def judged(changes: list[Any], configured: bool) -> Any:
    """Whether these changes may be made; all the reasons why not. Ranges are rclpy's to check."""
    reasons = []
    for change in changes:
        parameter = PARAMETERS.get(change.name)
        if parameter is None:
            continue
        if configured and not parameter.at_run_time:
            reasons.append(f"{change.name} is read when the node is configured: deactivate it and clean it up first")
        elif parameter.choices and change.value not in parameter.choices:
            reasons.append(f"{change.name} is one of {', '.join(parameter.choices)}, not {change.value}")
    verdict = SetParametersResult()
    verdict.successful, verdict.reason = not reasons, "; ".join(reasons)
    return verdict
