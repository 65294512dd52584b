r"""The floor is not level.

    F = -m g (slope_x + curve_x x + twist y, slope_y + twist x + curve_y y)     in `world`, at the centre of mass
    slope + fold b (cos across, sin across),    b = (x cos across + y sin across - fold_at) / (2 h), -1/2 to 1/2

m [kg], g = 9.80665 m/s2, slope_x and slope_y [rad]: rise of the floor along the axes of `world` (small angles), all
over it or, where it is curved, at the origin, where it is folded, on the line; x, y [m] the axle's centre in `world`;
curve_x, curve_y, twist [rad/m]: how much the slopes grow with every metre (the height's second derivatives; slopes of
a height have one twist). A floor that sags to its middle or to a drain has positive curves, one that drops to its
edges negative ones. Where boards or slabs meet the slope changes at a line, `fold_at` [m] from the origin along its
normal, across [rad] from the x axis, by fold [rad] (positive in a gutter, negative on a ridge), while the robot
passes it with its wheels, h [m] half the axle either way. The robot rolls downhill also with its motors off. A force
that changes with the place need be no floor: a spring or a cable that is fixed somewhere, a magnet, a stream of air
do the same, and no motion tells which it is: a curved floor is even odds. None of them pulls alike on either side of
a line: a folded floor is a floor.
Source: gravity on an inclined plane; the height's second order over the place.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from numba import njit

from fsm_calib.world2d.effects.effect import FORCE_DOUBT, Closure, Effect, Parameter
from fsm_calib.world2d.forces import add_force
from fsm_calib.world2d.slots import COM_X, COM_Y, COS, GRAVITY, HALF_AXLE, MASS, PLACE_X, PLACE_Y, SIN


@njit(error_model="numpy")
def pull(P, o, S, m, W):
    """Add the weight's component along the floor."""
    weight, x, y = GRAVITY * W[MASS], W[PLACE_X], W[PLACE_Y]
    slope_x, slope_y = P[o] + P[o + 2] * x + P[o + 4] * y, P[o + 1] + P[o + 4] * x + P[o + 3] * y
    if P[o + 5] != 0.0:
        c, s = math.cos(P[o + 6]), math.sin(P[o + 6])
        beyond = min(max(0.5 * (c * x + s * y - P[o + 7]) / W[HALF_AXLE], -0.5), 0.5)
        slope_x, slope_y = slope_x + P[o + 5] * beyond * c, slope_y + P[o + 5] * beyond * s
    gx, gy = -weight * slope_x, -weight * slope_y
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
        Parameter(
            "fold", "beta", "rad", 0.0, -0.2, 0.2, 0.0, "boards and slabs: 0.5 to 2 degrees",
            starts=(0.02, -0.02), step=1e-5, doubt=FORCE_DOUBT, rugged=True,
        ),
        Parameter(
            "across", "chi", "rad", 0.0, -7.0, 7.0, 0.0, "any", strength=False, mirror="negate",
            starts=(0.0, 0.25 * math.pi, 0.5 * math.pi, 0.75 * math.pi), step=5e-4,
        ),
        Parameter(
            "fold_at", "q_f", "m", 0.0, -100.0, 100.0, 0.0, "where the robot drives", strength=False,
            starts=(0.2, 0.35, 0.5, 0.65, 0.8), along="across", step=5e-3,
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
        Closure(
            "folded",
            ("slope_x", "slope_y", "fold", "across", "fold_at"),
            "two planes that meet at a line: boards, slabs, a gutter, a ridge",
            sentence="The floor rises by {slope_x} along x and {slope_y} along y where it folds, and by {fold} more "
            "beyond that line than before it: across {across}, {fold_at} from the origin.",
            extends=("plane", "curved"),
        ),
    ),
    order=80,
)  # fmt: skip
