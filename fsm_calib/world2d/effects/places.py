"""Soft places on the floor and soft spans of time, shared by effects (this module declares no effect).

Edges are `EDGE` wide: a wheel's contact patch crosses them in a few milliseconds, and a fit can feel where
they are.
"""

from __future__ import annotations

import math
from dataclasses import replace

from numba import njit

from fsm_calib.world2d.effects.parameter import Parameter
from fsm_calib.world2d.slots import COS, EDGE, HALF_AXLE, PLACE_X, PLACE_Y, SIN


@njit(error_model="numpy")
def rise(depth):
    """Return 0 outside, 1 inside, a smooth cubic between, of the depth [m] behind an edge (negative
    outside).
    """
    s = min(max(0.5 + 0.5 * depth / EDGE, 0.0), 1.0)
    return s * s * (3.0 - 2.0 * s)


@njit(error_model="numpy")
def in_disc(x, y, centre_x, centre_y, radius):
    """Return how far (0 to 1) the point (x, y) [m] lies inside a disc."""
    return rise(radius - math.sqrt((x - centre_x) ** 2 + (y - centre_y) ** 2))


@njit(error_model="numpy")
def in_area(x, y, centre_x, centre_y, half_x, half_y, roundness):
    """Return how far (0 to 1) the point (x, y) [m] lies inside a box along the axes of `world` (`roundness` 0) or
    the ellipse in it (1).
    """
    depth_x, depth_y = half_x - abs(x - centre_x), half_y - abs(y - centre_y)
    if roundness <= 0.0:
        return rise(depth_x) * rise(depth_y)
    reach = math.sqrt(((x - centre_x) / half_x) ** 2 + ((y - centre_y) / half_y) ** 2)
    depth = roundness * (1.0 - reach) * min(half_x, half_y) + (1.0 - roundness) * min(depth_x, depth_y)
    return rise(depth)


def centre_parameters(index: str, doubt: float = 0.0) -> tuple[Parameter, Parameter]:
    """Return the centre (x, y) of a place on the floor, symbols with `index`; doubt : beyond what places have [m]."""
    x = Parameter(
        "x", f"x_{index}", "m", 0.0, -100.0, 100.0, 0.1, "any", strength=False, step=6e-3, doubt=doubt
    )
    return x, replace(x, name="y", symbol=f"y_{index}", mirror="negate")


def heading_parameter(name: str, symbol: str, starts: tuple[float, ...]) -> Parameter:
    """Return the heading in the world [rad] for which something holds, tried from `starts`."""
    return Parameter(
        name,
        symbol,
        "rad",
        0.0,
        -7.0,
        7.0,
        0.0,
        "any heading",
        strength=False,
        mirror="negate",
        step=0.02,
        starts=starts,
    )


def spread_parameter(symbol: str) -> Parameter:
    """Return the parameter that says where a spot is felt: under each wheel or under the body's middle."""
    return Parameter(
        "spread",
        symbol,
        "1",
        1.0,
        0.0,
        1.0,
        1.0,
        "1 under the wheels, 0 under the body's middle",
        strength=False,
        fitted=False,
        starts=(1.0, 0.0),
    )


@njit(error_model="numpy")
def contact_arm(W, side, spread):
    """Return how far left of the body's middle [m] a contact is: under the wheel (`spread` 1) or nearer."""
    return spread * (W[HALF_AXLE] if side == 0 else -W[HALF_AXLE])


@njit(error_model="numpy")
def contact_place(W, arm):
    """Return where on the floor the contact `arm` [m] left of the body's middle stands [m]."""
    return W[PLACE_X] - arm * W[SIN], W[PLACE_Y] + arm * W[COS]


@njit(error_model="numpy")
def overlap(begin, end, start, stop):
    """Return the part (0 to 1) of the step from `begin` to `end` [s] that lies between `start` and `stop`
    [s].
    """
    return max(0.0, min(end, stop) - max(begin, start)) / (end - begin)
