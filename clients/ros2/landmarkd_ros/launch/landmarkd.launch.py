"""The node beside a camera: ros2 launch landmarkd_ros landmarkd.launch.py image:=/camera/image_raw.

It is configured and activated, unless autostart:=false leaves that to a manager of lifecycles.
"""

import launch.events
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, EmitEvent, RegisterEventHandler
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import LifecycleNode
from launch_ros.event_handlers import OnStateTransition
from launch_ros.events.lifecycle import ChangeState
from launch_ros.substitutions import FindPackageShare
from lifecycle_msgs.msg import Transition

TOPICS = {
    "image": "image",
    "compressed": "image/compressed",
    "camera_info": "camera_info",
    "near": "near",
    "far": "far",
    "near_info": "near/camera_info",
}


def generate_launch_description() -> LaunchDescription:
    """The node, its parameters, its topics and its states."""
    default = PathJoinSubstitution([FindPackageShare("landmarkd_ros"), "config", "landmarkd.yaml"])
    words = [
        DeclareLaunchArgument("params_file", default_value=default, description="parameters of the node"),
        DeclareLaunchArgument("namespace", default_value="", description="namespace of the node"),
        DeclareLaunchArgument("autostart", default_value="true", description="configure and activate it"),
    ]
    words += [
        DeclareLaunchArgument(name, default_value=topic, description=f"topic that {topic} is taken from")
        for name, topic in TOPICS.items()
    ]
    node = LifecycleNode(
        package="landmarkd_ros",
        executable="landmarkd_node",
        name="landmarkd",
        namespace=LaunchConfiguration("namespace"),
        output="screen",
        parameters=[LaunchConfiguration("params_file")],
        remappings=[(topic, LaunchConfiguration(name)) for name, topic in TOPICS.items()],
    )

    def change(transition: int, **conditions: IfCondition) -> EmitEvent:
        this = launch.events.matches_action(node)
        return EmitEvent(event=ChangeState(lifecycle_node_matcher=this, transition_id=transition), **conditions)

    autostart = IfCondition(LaunchConfiguration("autostart"))
    activate = RegisterEventHandler(
        OnStateTransition(
            target_lifecycle_node=node,
            start_state="configuring",
            goal_state="inactive",
            entities=[change(Transition.TRANSITION_ACTIVATE)],
        ),
        condition=autostart,
    )
    return LaunchDescription([*words, node, activate, change(Transition.TRANSITION_CONFIGURE, condition=autostart)])
