r"""The point whose pose is measured is not the axle centre.

    (x, y)_measured = (x, y) + Rot(theta) share(t) (x_s, y_s) - sway (a_x, a_y)

(x_s, y_s) [m]: the sensor's (or tag's) place in `base`, which it reaches as its mount gives way (share: `creep`).
sway [s2]: how far a mast bends against the robot's acceleration (a_x, a_y) [m/s2], one over the square of its
natural frequency in rad/s, far below which all is as if at rest. Sources: lever arm, hand-eye calibration; a base that
is shaken: Rao, Mechanical Vibrations, 6th ed. 2018, section 3.6.
"""

from __future__ import annotations

import numpy as np

from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects.creep import CREEP_PARAMETERS, creeping, crept
from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter


def bend(p: FloatArray, t: FloatArray, poses: FloatArray) -> FloatArray:
    """Return poses (n, 3) as a bending mast has them, at increasing times t (n,) [s]."""
    sway = p[4]
    if sway == 0.0 or len(t) < 2:
        return poses
    bent = poses.copy()
    for axis in (0, 1):
        bent[:, axis] -= sway * np.gradient(np.gradient(poses[:, axis], t), t)
    return bent


def shift(p: FloatArray, times: FloatArray, poses: FloatArray) -> FloatArray:
    """Return the poses of the sensor's point, shape (n, 3)."""
    moved, share = poses.copy(), crept(p[2:4], times)
    x, y = share * p[0], share * p[1]
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    moved[:, 0] += c * x - s * y
    moved[:, 1] += s * x + c * y
    return moved


EFFECT = Effect(
    name="sensor_offset",
    family="sensor",
    summary="the measured point is not the axle centre",
    equation="(x, y)_measured = (x, y) + Rot(theta) share(t) (x_s, y_s) - sway (a_x, a_y)",
    parameters=(
        Parameter("x", "x_s", "m", 0.0, -1.0, 1.0, 0.03, "2 to 10 mm when meant to be centred"),
        Parameter(
            "y", "y_s", "m", 0.0, -1.0, 1.0, -0.015, "2 to 10 mm when meant to be centred", mirror="negate"
        ),
        *CREEP_PARAMETERS,
        Parameter(
            "sway",
            "k_s",
            "s2",
            0.0,
            0.0,
            0.05,
            0.005,
            "0.4 to 20 ms2: masts that swing at 8 to 1 Hz",
            step=1e-4,
        ),
    ),
    hooks={"smooth": bend, "mount": shift},
    channels=("sensor", "lateral"),
    regimes=("turning",),
    separates="the measured point circles when the robot spins in place, and nothing shows on straights",
    rivals=("sensor_yaw", "misplaced_marker", "lateral_slip", "payload_offset"),
    manoeuvre="spins in place both ways",
    sentence="The measured point lies {x:ahead|behind} and {y:left|right} of the axle's centre.",
    source="lever arm of a sensor",
    closures=(
        Closure("full", ("x", "y"), "it stays where it is"),
        creeping(
            ("x", "y"),
            "The measured point lies {x:ahead|behind} and {y:left|right} of the axle's centre at last; "
            "{creep} of that it moves within {settle}.",
        ),
        Closure(
            "on a mast",
            ("x", "y", "sway"),
            "it sways against the robot's acceleration",
            sentence="The measured point lies {x:ahead|behind} and {y:left|right} of the axle's centre, on a mast that "
            "bends by {sway} of the acceleration.",
            source="Rao 2018, section 3.6",
            extends=("full",),
        ),
    ),
    order=10,
)
