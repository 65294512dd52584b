"""The poses of a plane that explain its points in one image: two at most, each other's mirror image.

Source: Collins and Bartoli, Infinitesimal plane-based pose estimation, IJCV 109 (2014), 252-286 (OpenCV's IPPE).
"""

from __future__ import annotations

import cv2
import numpy as np

from fsm_calib.types import FloatArray


def plane_poses(
    points: FloatArray, rays: FloatArray, method: int = cv2.SOLVEPNP_IPPE
) -> list[tuple[FloatArray, FloatArray]]:
    """Return the poses that a plane has, the better first: rotation vector (3, 1) [rad] and shift (3, 1) [m].

    The plane-based solution takes the root of a difference that rounding can make negative, and is then no number;
    the iterative one, which stands in where nothing else is left, has no such place.

    Parameters
    ----------
    points : array, shape (n, 3) [m]
        Points of the plane z = 0, in its own frame; at least 4.
    rays : array, shape (n, 2) [1]
        Where they are seen, undistorted: x / z and y / z in the camera frame.
    method : int
        SOLVEPNP_IPPE, or SOLVEPNP_IPPE_SQUARE for the corners of a square in that method's order.
    """
    points, rays = np.ascontiguousarray(points), np.ascontiguousarray(rays)
    _, turns, shifts, _ = cv2.solvePnPGeneric(points, rays, np.eye(3), None, flags=method)
    pairs = [
        (np.asarray(turn, float), np.asarray(shift, float)) for turn, shift in zip(turns, shifts, strict=True)
    ]
    found = [pair for pair in pairs if np.isfinite(pair).all()]
    if found:
        return found
    _, turn, shift = cv2.solvePnP(points, rays, np.eye(3), None, flags=cv2.SOLVEPNP_ITERATIVE)
    return [(np.asarray(turn, float), np.asarray(shift, float))]
