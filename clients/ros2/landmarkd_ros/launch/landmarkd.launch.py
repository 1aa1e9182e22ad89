"""The node beside a camera: ros2 launch landmarkd_ros landmarkd.launch.py image:=/camera/image_raw."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

TOPICS = {"image": "image", "near": "near", "far": "far", "near_info": "near/camera_info"}


def generate_launch_description() -> LaunchDescription:
    """The node, its parameters and its topics."""
    default = PathJoinSubstitution([FindPackageShare("landmarkd_ros"), "config", "landmarkd.yaml"])
    words = [DeclareLaunchArgument("params_file", default_value=default, description="parameters of the node")]
    words += [
        DeclareLaunchArgument(name, default_value=topic, description=f"topic that {topic} is taken from")
        for name, topic in TOPICS.items()
    ]
    node = Node(
        package="landmarkd_ros",
        executable="landmarkd_node",
        name="landmarkd",
        output="screen",
        parameters=[LaunchConfiguration("params_file")],
        remappings=[(topic, LaunchConfiguration(name)) for name, topic in TOPICS.items()],
    )
    return LaunchDescription([*words, node])
