"""The package as colcon builds it."""

from glob import glob

from setuptools import find_packages, setup

PACKAGE = "landmarkd_ros"

setup(
    name=PACKAGE,
    version="0.1.0",
    packages=find_packages(exclude=["test"]),
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        (f"share/{PACKAGE}/launch", glob("launch/*.launch.py")),
        (f"share/{PACKAGE}/config", glob("config/*.yaml")),
    ],
    install_requires=["setuptools", "landmarkd", "numpy", "pillow"],
    # Definitions of messages and bags without ROS.
    extras_require={"test": ["pytest", "rosbags>=0.10"]},
    zip_safe=True,
    maintainer="The landmarkd maintainers",
    maintainer_email="maintainers@landmarkd.invalid",
    description="Where a robot is, what it sees and how far it is, by a landmarkd service",
    license="MIT OR Apache-2.0",
    entry_points={"console_scripts": [f"landmarkd_node = {PACKAGE}.node:main"]},
)
