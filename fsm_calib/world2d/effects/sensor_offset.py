r"""The point whose pose is measured is not the axle centre.

    (x, y)_measured = (x, y) + Rot(theta) (x_s, y_s)

(x_s, y_s) [m]: the sensor's (or tag's) place in `base`. Source: lever arm, hand-eye calibration.
"""

from __future__ import annotations

import numpy as np

from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects.effect import Effect, Parameter


def shift(p: FloatArray, poses: FloatArray, places: FloatArray) -> FloatArray:
    """Return the poses of the sensor's point, shape (n, 3)."""
    moved = poses.copy()
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    moved[:, 0] += c * p[0] - s * p[1]
    moved[:, 1] += s * p[0] + c * p[1]
    return moved


EFFECT = Effect(
    name="sensor_offset",
    family="sensor",
    summary="the measured point is not the axle centre",
    equation="(x, y)_measured = (x, y) + Rot(theta) (x_s, y_s)",
    parameters=(
        Parameter("x", "x_s", "m", 0.0, -1.0, 1.0, 0.03, "2 to 10 mm when meant to be centred"),
        Parameter(
            "y", "y_s", "m", 0.0, -1.0, 1.0, -0.015, "2 to 10 mm when meant to be centred", mirror="negate"
        ),
    ),
    hooks={"observe": shift},
    channels=("sensor", "lateral"),
    regimes=("turning",),
    separates="the measured point circles when the robot spins in place, and nothing shows on straights",
    rivals=("sensor_yaw", "misplaced_marker", "lateral_slip", "payload_offset"),
    manoeuvre="spins in place both ways",
    sentence="The measured point lies {x:ahead|behind} and {y:left|right} of the axle's centre.",
    source="lever arm of a sensor",
    order=10,
)
