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
from fsm_calib.world2d.effects.creep import CREEP_PARAMETERS, creeping, crept
from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.effects.places import heading_parameter

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
        heading_parameter("towards", "phi_w", starts=(0.0, 0.8, 1.6, 2.4)),
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
        creeping(
            ("yaw",),
            "The measured heading is turned by {yaw:to the left|to the right} at last; {creep} of that comes "
            "within {settle}.",
        ),
        *(
            Closure(
                name,
                ("yaw", "swing", "towards"),
                summary,
                sentence=SWINGING,
                source=source,
                fixes={"folds": folds},
                extends=("full",),
            )
            for name, folds, summary, source in (
                (
                    "foreshortened",
                    2.0,
                    "the view of the floor is foreshortened: off twice a turn",
                    "Hartley & Zisserman 2004, section 2.4",
                ),
                ("tilted", 1.0, "a tilted tag in one view: off once a turn", "Olson, ICRA 2011"),
            )
        ),
    ),
    order=20,
)
