r"""The measured heading is turned by a constant angle.

    theta_measured = theta + yaw

yaw [rad] of the sensor (or tag) in `base`: the robot then seems to crab. Source: hand-eye calibration.
"""

from __future__ import annotations

from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects.effect import Effect, Parameter


def turn(p: FloatArray, poses: FloatArray, places: FloatArray) -> FloatArray:
    """Return the poses with turned headings, shape (n, 3)."""
    turned = poses.copy()
    turned[:, 2] += p[0]
    return turned


EFFECT = Effect(
    name="sensor_yaw",
    family="sensor",
    summary="the measured heading is turned",
    equation="theta_measured = theta + yaw",
    parameters=(Parameter("yaw", "psi", "rad", 0.0, -1.6, 1.6, 0.05, "1 to 5 degrees", mirror="negate"),),
    hooks={"observe": turn},
    channels=("sensor", "lateral"),
    regimes=("driving",),
    separates="crabs in proportion to the speed, everywhere, also on straights",
    rivals=("sensor_offset", "misplaced_marker", "lateral_slip"),
    manoeuvre="straights forwards and backwards on two headings",
    sentence="The measured heading is turned by {yaw:to the left|to the right}.",
    source="hand-eye calibration",
    order=20,
)
