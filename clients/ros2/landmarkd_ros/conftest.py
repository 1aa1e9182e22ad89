"""The tests take the service and the pictures of the Python client's tests, and stand-ins of ROS."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE / "test"), str(HERE.parents[1] / "python" / "tests")]

import ros
from fixtures import _no_key_from_outside, client, folder, home, pytest_configure, service

ros.install()

__all__ = ["_no_key_from_outside", "client", "folder", "home", "pytest_configure", "service"]
