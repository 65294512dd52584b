"""Soft places on the floor and soft spans of time, shared by effects (this module declares no effect).

Edges are `EDGE` wide: a wheel's contact patch crosses them in a few milliseconds, and a fit can feel where
they are.
"""

from __future__ import annotations

import math

from numba import njit

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
    return rise(radius - math.hypot(x - centre_x, y - centre_y))


@njit(error_model="numpy")
def in_box(x, y, centre_x, centre_y, half_x, half_y):
    """Return how far (0 to 1) the point (x, y) [m] lies inside a box along the axes of `world`."""
    return rise(half_x - abs(x - centre_x)) * rise(half_y - abs(y - centre_y))


@njit(error_model="numpy")
def wheel_place(W, side):
    """Return where a wheel stands [m], side 0 left, 1 right, from the place that effects go by."""
    arm = W[HALF_AXLE] if side == 0 else -W[HALF_AXLE]
    return W[PLACE_X] - arm * W[SIN], W[PLACE_Y] + arm * W[COS]


@njit(error_model="numpy")
def overlap(begin, end, start, stop):
    """Return the part (0 to 1) of the step from `begin` to `end` [s] that lies between `start` and `stop`
    [s].
    """
    return max(0.0, min(end, stop) - max(begin, start)) / (end - begin)
