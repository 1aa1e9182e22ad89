"""`sensor_msgs/CameraInfo` as the service's camera, without ROS: anything with the message's fields will do."""

from __future__ import annotations

from typing import Any

from landmarkd import Camera

MODELS = {"", "plumb_bob", "rational_polynomial"}
"""Models whose distortion is that of the service, the last one if its denominator is 1."""


def camera(info: Any, rectified: bool) -> Camera:
    """The camera of a picture: by K and D, or by P for a rectified one.

    Raises:
        ValueError: it isn't calibrated, or has a model that the service doesn't know.

    """
    matrix = info.p if rectified else info.k
    fx, cx, fy, cy = (float(matrix[place]) for place in ((0, 2, 5, 6) if rectified else (0, 2, 4, 5)))
    if fx <= 0 or fy <= 0:
        raise ValueError("the camera isn't calibrated: CameraInfo's focal length is 0")
    if info.binning_x > 1 or info.binning_y > 1 or info.roi.width or info.roi.height:
        raise ValueError("binning and a region of interest aren't read: publish CameraInfo of the picture as it is")
    distortion = [float(each) for each in info.d]
    if rectified or not any(distortion):
        return Camera(fx, fy, cx, cy, info.width, info.height)
    if info.distortion_model not in MODELS or any(distortion[5:]):
        raise ValueError(
            f"the distortion {info.distortion_model or 'of more than five numbers'} isn't one of the service: "
            "rectify the pictures (image_proc) and set `rectified`"
        )
    k1, k2, p1, p2, k3 = (distortion + [0.0] * 5)[:5]
    return Camera(fx, fy, cx, cy, info.width, info.height, k1, k2, p1, p2, k3)
