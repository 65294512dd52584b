r"""The floor is not level.

    F = -m g (slope_x, slope_y)       in `world`, at the centre of mass

m [kg], g = 9.80665 m/s2, slope_x and slope_y [rad]: rise of the floor along the axes of `world` (small
angles). The robot rolls downhill also with its motors off. Source: gravity on an inclined plane.
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.effects.effect import FORCE_DOUBT, Effect, Parameter
from fsm_calib.world2d.forces import add_force
from fsm_calib.world2d.slots import COM_X, COM_Y, COS, GRAVITY, MASS, SIN


@njit(error_model="numpy")
def pull(P, o, S, m, W):
    """Add the weight's component along the floor."""
    gx, gy = -GRAVITY * W[MASS] * P[o], -GRAVITY * W[MASS] * P[o + 1]
    fx, fy = W[COS] * gx + W[SIN] * gy, W[COS] * gy - W[SIN] * gx
    add_force(W, fx, fy, W[COM_X] * fy - W[COM_Y] * fx)


EFFECT = Effect(
    name="floor_tilt",
    family="floor",
    summary="the floor is not level",
    equation="F = -m g (slope_x, slope_y) in the world",
    parameters=(
        Parameter("slope_x", "alpha_x", "rad", 0.0, -0.2, 0.2, 0.02, "0.5 to 3 degrees", doubt=FORCE_DOUBT),
        Parameter(
            "slope_y",
            "alpha_y",
            "rad",
            0.0,
            -0.2,
            0.2,
            -0.015,
            "0.5 to 3 degrees",
            mirror="negate",
            doubt=FORCE_DOUBT,
        ),
    ),
    hooks={"step": pull},
    reads=("heading",),
    channels=("forward", "turn"),
    regimes=("heading", "standstill"),
    separates="changes sign with the heading and creeps at standstill; a carpet's nap does not creep",
    rivals=("carpet_nap", "motor_reverse_asymmetry", "external_push"),
    manoeuvre="straights on four headings, each followed by a rest with the wheels at zero",
    sentence="The floor rises by {slope_x} along x and {slope_y} along y.",
    source="gravity on an inclined plane",
    order=80,
)
