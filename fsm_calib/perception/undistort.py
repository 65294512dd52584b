"""Rectified images, for people to judge a lens model by: straight things must look straight."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from fsm_calib.types import CameraModel

_LARGEST_SIDE = 640  # px; report pictures are no larger


def undistorted(image: NDArray[np.uint8], camera: CameraModel, alpha: float = 1.0) -> NDArray[np.uint8]:
    """Return the image without the lens's distortion; alpha 1 keeps every pixel, 0 shows no border (ROS's
    words).
    """
    size = (camera.width, camera.height)
    if camera.model == "equidistant":
        args = (camera.matrix, camera.distortion)
        wide = cv2.fisheye.estimateNewCameraMatrixForUndistortRectify(*args, size, np.eye(3), balance=alpha)
        return np.asarray(cv2.fisheye.undistortImage(image, *args, None, wide), dtype=np.uint8)
    matrix, _ = cv2.getOptimalNewCameraMatrix(camera.matrix, camera.distortion, size, alpha, size)
    return np.asarray(cv2.undistort(image, camera.matrix, camera.distortion, None, matrix), dtype=np.uint8)


def as_png(image: NDArray[np.uint8]) -> bytes:
    """Return the image as PNG bytes, made smaller if larger than a report needs."""
    scale = min(1.0, _LARGEST_SIDE / max(image.shape[:2]))
    small = (
        image if scale == 1.0 else cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    )
    return bytes(cv2.imencode(".png", small)[1])
