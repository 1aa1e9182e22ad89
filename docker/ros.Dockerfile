# The ROS 2 package built by colcon and tested under ROS. Build it from the root of the repository:
#   docker build -f docker/ros.Dockerfile --build-arg ROS_DISTRO=humble .
# A build that succeeds has passed the tests. ROS_DISTRO is humble or jazzy.
ARG ROS_DISTRO=humble

# Bullseye's C library is older than that of both distributions.
FROM rust:1.95-bullseye AS build
WORKDIR /build
COPY . .
RUN cargo build --locked --release --bin landmarkd

FROM ros:${ROS_DISTRO}-ros-base
SHELL ["/bin/bash", "-o", "pipefail", "-c"]
# Ubuntu of Jazzy keeps pip out of the system's Python unless it is told.
ENV PIP_BREAK_SYSTEM_PACKAGES=1 LANDMARKD_BINARY=/usr/local/bin/landmarkd LANDMARKD_DOCUMENT=/landmarkd/openapi/landmarkd.json
COPY --from=build /build/target/release/landmarkd /usr/local/bin/landmarkd
COPY openapi /landmarkd/openapi
COPY clients /landmarkd/clients
RUN apt-get update && apt-get install --yes --no-install-recommends python3-pip \
 && python3 -m pip install "/landmarkd/clients/python[test]" 'rosbags>=0.10' \
 && mkdir -p /ws/src && ln -s /landmarkd/clients/ros2/landmarkd_ros /ws/src/landmarkd_ros \
 && rosdep update && rosdep install --from-paths /ws/src --ignore-src --default-yes \
 && rm -rf /var/lib/apt/lists/*
WORKDIR /ws
RUN source "/opt/ros/$ROS_DISTRO/setup.bash" && colcon build --packages-select landmarkd_ros \
 && colcon test --packages-select landmarkd_ros --event-handlers console_direct+ \
 && colcon test-result --verbose
RUN source install/setup.bash && python3 src/landmarkd_ros/test/under_ros.py
