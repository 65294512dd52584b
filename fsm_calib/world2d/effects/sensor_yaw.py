r"""The measured heading is turned, by a constant angle or by one that creeps or swings with the view.

    theta_measured = theta + share(t) yaw + swing sin(folds (theta - towards))

yaw [rad] of the sensor (or tag) in `base`, which it reaches as its mount gives way (share: `creep`): the robot then
seems to crab. swing [rad]: how far the measured heading is off by the direction in which the robot is seen, towards
[rad] where that vanishes; folds [1]: 2 where the view is foreshortened (tan theta_measured = (1 + 2 swing) tan theta),
1 where one view tells a tilted tag's heading. Sources: hand-eye calibration; foreshortening: Hartley & Zisserman,
Multiple View Geometry, 2nd ed. 2004, section 2.4 (affinities); poses of a tag from one view: Olson, ICRA 2011.
"""

from __future__ import annotations

import numpy as np

from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects.creep import CREEP_PARAMETERS, crept
from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter

SWINGING = (
    "The measured heading is turned by {yaw:to the left|to the right}, and by up to {swing} with the view."
)


def turn(p: FloatArray, times: FloatArray, poses: FloatArray) -> FloatArray:
    """Return the poses with turned headings, shape (n, 3)."""
    yaw, swing, towards, folds = p[0], p[3], p[4], p[5]
    turned = poses.copy()
    turned[:, 2] += crept(p[1:3], times) * yaw
    if swing != 0.0:
        turned[:, 2] += swing * np.sin(folds * (poses[:, 2] - towards))
    return turned


EFFECT = Effect(
    name="sensor_yaw",
    family="sensor",
    summary="the measured heading is turned",
    equation="theta_measured = theta + share(t) yaw + swing sin(folds (theta - towards))",
    parameters=(
        Parameter("yaw", "psi", "rad", 0.0, -1.6, 1.6, 0.05, "1 to 5 degrees", mirror="negate"),
        *CREEP_PARAMETERS,
        Parameter(
            "swing",
            "psi_w",
            "rad",
            0.0,
            -0.3,
            0.3,
            0.01,
            "a quarter of the angle by which a tag is tilted, or half of a view's foreshortening",
            step=1e-3,
            starts=(0.01,),
        ),
        Parameter(
            "towards",
            "phi_w",
            "rad",
            0.0,
            -7.0,
            7.0,
            0.0,
            "any heading",
            strength=False,
            mirror="negate",
            step=0.02,
            starts=(0.0, 0.8, 1.6, 2.4),
        ),
        Parameter(
            "folds",
            "n_w",
            "1",
            2.0,
            1.0,
            2.0,
            2.0,
            "2 a foreshortened view, 1 a tilted tag",
            strength=False,
            fitted=False,
        ),
    ),
    hooks={"mount": turn},
    channels=("sensor", "lateral"),
    regimes=("driving",),
    separates="crabs in proportion to the speed, everywhere, also on straights",
    rivals=("sensor_offset", "misplaced_marker", "lateral_slip"),
    manoeuvre="straights forwards and backwards on two headings",
    sentence="The measured heading is turned by {yaw:to the left|to the right}.",
    source="hand-eye calibration",
    closures=(
        Closure("full", ("yaw",), "by as much all the time"),
        Closure(
            "creeping",
            ("yaw", "creep", "settle"),
            "its mount gives way during a drive",
            sentence="The measured heading is turned by {yaw:to the left|to the right} at last; {creep} of that comes "
            "within {settle}.",
            source="Ferry 1980, chapter 3",
            extends=("full",),
        ),
        Closure(
            "foreshortened",
            ("yaw", "swing", "towards"),
            "the view of the floor is foreshortened: off twice a turn",
            sentence=SWINGING,
            source="Hartley & Zisserman 2004, section 2.4",
            fixes={"folds": 2.0},
            extends=("full",),
        ),
        Closure(
            "tilted",
            ("yaw", "swing", "towards"),
            "a tilted tag in one view: off once a turn",
            sentence=SWINGING,
            source="Olson, ICRA 2011",
            fixes={"folds": 1.0},
            extends=("full",),
        ),
    ),
    order=20,
)
