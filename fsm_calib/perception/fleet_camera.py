"""What the cameras of real Duckiebots look like: the start of every calibration and its gate of sanity.

Medians and robust standard deviations of 48 intrinsic files of real robots (duckietown/dt-core at cc437e83,
log-calib-config); pitch, height and distance ahead of the axle from 38 of their homographies.
"""

from __future__ import annotations

import numpy as np

from fsm_calib.perception.lens import camera_model
from fsm_calib.types import CameraModel, FloatArray

FLEET_SIZE = (640, 480)  # px, width and height of the fleet's images
#: fx, fy, cx, cy [px], k1, k2, p1, p2, k3, k4, k5, k6
FLEET_MEDIAN = np.array([316.6, 317.3, 320.4, 231.4, -0.269, 0.050, 0.0006, 0.0002, 0.0, 0.0, 0.0, 0.0])
FLEET_DEVIATION = np.array([6.3, 6.7, 15.0, 13.7, 0.016, 0.009, 0.0027, 0.0016, 0.0, 0.0, 0.0, 0.0])
_LARGEST_FOCAL_CHANGE_PX = 90.0  # the fleet's farthest camera is 87 px from the median
_LARGEST_CENTRE_CHANGE_PX = 60.0  # twice the fleet's farthest


def fleet_start(image_size: tuple[int, int]) -> FloatArray:
    """Return the fleet's median intrinsics (12,) scaled to images of `image_size` (width, height) [px]."""
    start = FLEET_MEDIAN.copy()
    if image_size != FLEET_SIZE:
        start[:2] *= image_size[0] / FLEET_SIZE[0]
        start[2:4] = (image_size[0] - 1) / 2.0, (image_size[1] - 1) / 2.0
    return start


def fleet_camera() -> CameraModel:
    """Return the camera of the median Duckiebot."""
    return camera_model(FLEET_MEDIAN, FLEET_SIZE)


def why_not_a_duckiebot(intrinsics: FloatArray, image_size: tuple[int, int]) -> str:
    """Return the sentence that refuses intrinsics no Duckiebot camera has, or an empty string."""
    median, scale = fleet_start(image_size), image_size[0] / FLEET_SIZE[0]
    change = np.abs(intrinsics[:4] - median[:4]) / scale
    limits = (_LARGEST_FOCAL_CHANGE_PX,) * 2 + (_LARGEST_CENTRE_CHANGE_PX,) * 2
    for name, value, off, limit in zip(("fx", "fy", "cx", "cy"), intrinsics, change, limits, strict=False):
        if off > limit:
            return f"{name} = {value:.0f} px is {off:.0f} px from the fleet's median, {limit:.0f} px allowed"
    return ""
