"""The equidistant lens of fisheye cameras, as factors of the ray: what `lens` needs of it.

A ray at the angle theta from the axis, r = tan(theta) = |(X, Y)| / Z, is seen at::

    d(theta) = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8)
    u = fx (d / r) X / Z + cx,   v = fy (d / r) Y / Z + cy

Source: Kannala & Brandt, "A Generic Camera Model and Calibration Method for Conventional, Wide-Angle, and Fish-Eye
Lenses", IEEE PAMI 28 (2006) 1335; OpenCV's `cv2.fisheye`, ROS's `equidistant` and Kalibr's `equi` are the same.
"""

from __future__ import annotations

import numpy as np

from fsm_calib.types import FloatArray

INTRINSICS = ("fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4")
SIZE = len(INTRINSICS)
_NEAR_AXIS = 1e-8  # r^2: nearer, the first two terms of the series are exact to the last digit


def _angle(r2: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return r [1], its square kept off zero, and theta [rad]."""
    radius = np.sqrt(np.maximum(r2, _NEAR_AXIS))
    return radius, np.arctan(radius)


def factor(vector: FloatArray, r2: FloatArray) -> FloatArray:
    """Return d / r at squared radii `r2` [1]."""
    k1, k2, k3, k4 = vector[4:8].tolist()
    radius, theta = _angle(r2)
    t2 = theta * theta
    seen = theta * (1.0 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4))))
    return np.where(r2 > _NEAR_AXIS, seen / radius, 1.0 + (k1 - 1.0 / 3.0) * r2)


def slope(vector: FloatArray, r2: FloatArray) -> FloatArray:
    """Return the derivative of d / r by r^2."""
    k1, k2, k3, k4 = vector[4:8].tolist()
    radius, theta = _angle(r2)
    t2 = theta * theta
    seen = theta * (1.0 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4))))
    by_theta = 1.0 + t2 * (3.0 * k1 + t2 * (5.0 * k2 + t2 * (7.0 * k3 + t2 * 9.0 * k4)))
    by_radius = by_theta / (1.0 + radius * radius)
    away = (by_radius * radius - seen) / (2.0 * radius**3)
    return np.where(r2 > _NEAR_AXIS, away, k1 - 1.0 / 3.0)


def by_coefficients(r2: FloatArray) -> FloatArray:
    """Return the derivatives of d / r by k1 to k4, shape (..., 4)."""
    radius, theta = _angle(r2)
    powers = np.stack([theta**3, theta**5, theta**7, theta**9], axis=-1)
    return powers / radius[..., None]


def coefficients_like(wanted: FloatArray, r2: FloatArray) -> FloatArray:
    """Return k1 to k4 (4,) whose factor comes nearest to `wanted` (n,) at squared radii `r2` (n,), by least squares."""
    radius, theta = _angle(r2)
    return np.asarray(np.linalg.lstsq(by_coefficients(r2), wanted - theta / radius, rcond=None)[0])
