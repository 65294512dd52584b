r"""The floor is not level.

    F = -m g (slope_x + curve_x x + twist y, slope_y + twist x + curve_y y)     in `world`, at the centre of mass

m [kg], g = 9.80665 m/s2, slope_x and slope_y [rad]: rise of the floor along the axes of `world` (small angles), all
over it or, where it is curved, at the origin; x, y [m] the axle's centre in `world`; curve_x, curve_y, twist [rad/m]:
how much the slopes grow with every metre (the height's second derivatives; slopes of a height have one twist). A floor
that sags to its middle or to a drain has positive curves, one that drops to its edges negative ones. The robot rolls
downhill also with its motors off. A force that changes with the place need be no floor: a spring or a cable that is
fixed somewhere, a magnet, a stream of air do the same, and no motion tells which it is: a curved floor is even odds.
Source: gravity on an inclined plane; the height's second order over the place.
"""

from __future__ import annotations

from collections.abc import Mapping

from numba import njit

from fsm_calib.world2d.effects.effect import FORCE_DOUBT, Closure, Effect, Parameter
from fsm_calib.world2d.forces import add_force
from fsm_calib.world2d.slots import COM_X, COM_Y, COS, GRAVITY, MASS, PLACE_X, PLACE_Y, SIN


@njit(error_model="numpy")
def pull(P, o, S, m, W):
    """Add the weight's component along the floor."""
    weight = GRAVITY * W[MASS]
    gx = -weight * (P[o] + P[o + 2] * W[PLACE_X] + P[o + 4] * W[PLACE_Y])
    gy = -weight * (P[o + 1] + P[o + 4] * W[PLACE_X] + P[o + 3] * W[PLACE_Y])
    fx, fy = W[COS] * gx + W[SIN] * gy, W[COS] * gy - W[SIN] * gx
    add_force(W, fx, fy, W[COM_X] * fy - W[COM_Y] * fx)


def may_be_a_pull(numbers: Mapping[str, float]) -> bool:
    """Return whether something that pulls or pushes by the place does the same: wherever the floor is curved."""
    return any(numbers[name] != 0.0 for name in ("curve_x", "curve_y", "twist"))


CURVED = "1 to 2 % of slope over a metre or two towards a drain"

EFFECT = Effect(
    name="floor_tilt",
    family="floor",
    summary="the floor is not level",
    equation="F = -m g (slope + curve p) in the world",
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
        *(
            Parameter(
                name,
                symbol,
                "rad/m",
                0.0,
                -0.1,
                0.1,
                0.0,
                CURVED,
                mirror=mirror,
                doubt=FORCE_DOUBT,
                step=1e-5,
            )
            for name, symbol, mirror in (
                ("curve_x", "kappa_x", "same"),
                ("curve_y", "kappa_y", "same"),
                ("twist", "kappa_xy", "negate"),
            )
        ),
    ),
    hooks={"step": pull},
    reads=("place", "heading"),
    channels=("forward", "turn"),
    regimes=("heading", "standstill"),
    separates="changes sign with the heading and creeps at standstill; a carpet's nap does not creep",
    rivals=("carpet_nap", "motor_reverse_asymmetry", "external_push"),
    manoeuvre="straights on four headings, each followed by a rest with the wheels at zero",
    sentence="The floor rises by {slope_x} along x and {slope_y} along y.",
    source="gravity on an inclined plane",
    closures=(
        Closure("plane", ("slope_x", "slope_y"), "the same slope everywhere"),
        Closure(
            "curved",
            ("slope_x", "slope_y", "curve_x", "curve_y", "twist"),
            "a slope that changes with the place: a hollow, a crown, a gutter",
            sentence="The floor rises by {slope_x} along x and {slope_y} along y at the origin, and by {curve_x} and "
            "{curve_y} more with every metre along them.",
            has_twin=may_be_a_pull,
        ),
    ),
    order=80,
)
