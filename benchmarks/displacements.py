"""How far poses are apart over a time, in the frame of the first: what sizes of effects and floors are made of."""

from __future__ import annotations

import math

import numpy as np

from fsm_calib.types import FloatArray

Poses = tuple[FloatArray, FloatArray, FloatArray]


def moved(poses: Poses, first: FloatArray, last: FloatArray) -> FloatArray:
    """Return displacements (n, 3) between rows, in the frame of the first [m, m, rad]."""
    x, y, yaw = poses
    dx, dy, c, s = x[last] - x[first], y[last] - y[first], np.cos(yaw[first]), np.sin(yaw[first])
    turn = np.remainder(yaw[last] - yaw[first] + math.pi, 2.0 * math.pi) - math.pi
    return np.stack([c * dx + s * dy, c * dy - s * dx, turn], axis=1)


def floor_of(stamps: FloatArray, exact: Poses, seen: Poses) -> dict[str, float]:
    """Return the root mean squares of measured minus exact displacements over 2 s, one from each pose."""
    last = np.searchsorted(stamps, stamps + 2.0 - 1e-9)
    first = np.flatnonzero(last < len(stamps))
    off = moved(seen, first, last[first]) - moved(exact, first, last[first])
    turn = np.remainder(off[:, 2] + math.pi, 2.0 * math.pi) - math.pi
    return {
        "xy_m": float(np.sqrt(np.mean(off[:, 0] ** 2 + off[:, 1] ** 2))),
        "theta_rad": float(np.sqrt(np.mean(turn**2))),
    }
