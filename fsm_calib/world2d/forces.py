"""Forces on the body during one step, in the form in which `dynamics` solves for them: constant, dampers, or
dry friction.
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.arithmetic import ARITHMETIC
from fsm_calib.world2d.dry_contacts import ANY_WAY, add_contact
from fsm_calib.world2d.slots import CREEP_SPEED, DAMP, FORCE_X, FORCE_Y, MOMENT, STEP

STEPS_TO_STOP = 4.0
"""Steps within which dry friction of a place could stop a motion for it to be treated as a damper."""


@njit(**ARITHMETIC, forceinline=True)
def add_force(W, fx, fy, moment):
    """Add a constant force (fx, fy) [N] in `base` at the axle centre and a moment [N m] to this step."""
    W[FORCE_X] += fx
    W[FORCE_Y] += fy
    W[MOMENT] += moment


@njit(**ARITHMETIC, forceinline=True)
def add_damper(W, px, py, kx, ky):
    """Add a damper at the point (px, py) [m] of `base` with stiffness kx along x and ky along y [N s/m]."""
    W[DAMP] += kx
    W[DAMP + 2] -= kx * py
    W[DAMP + 3] += ky
    W[DAMP + 4] += ky * px
    W[DAMP + 5] += kx * py * py + ky * px * px


@njit(**ARITHMETIC)
def add_oblique_damper(W, px, py, dx, dy, k):
    """Add a damper of stiffness k [N s/m] at the point (px, py) [m] that acts along the unit vector (dx, dy)
    of `base`.
    """
    arm = px * dy - py * dx
    W[DAMP] += k * dx * dx
    W[DAMP + 1] += k * dx * dy
    W[DAMP + 2] += k * dx * arm
    W[DAMP + 3] += k * dy * dy
    W[DAMP + 4] += k * dy * arm
    W[DAMP + 5] += k * arm * arm


@njit(**ARITHMETIC)
def add_dry_point(W, px, py, size):
    """Add dry friction of `size` [N] at the point (px, py) [m] of `base`, against whatever way it slides."""
    add_contact(W, size, px, py, 0.0, ANY_WAY, ANY_WAY)


@njit(**ARITHMETIC)
def add_dry_way(W, px, py, dx, dy, size):
    """Add dry friction of `size` [N] at the point (px, py) [m] along the unit vector (dx, dy) of `base` alone."""
    add_contact(W, size, dx, dy, px * dy - py * dx, 0.0, 0.0)


@njit(**ARITHMETIC)
def add_dry_moment(W, size, rate):
    """Add a dry moment of `size` [N m] against turning; below `rate` [rad/s] it acts as a damper."""
    add_dry_moments(W, size, rate, rate)


@njit(**ARITHMETIC)
def add_dry_moments(W, size, rate_l, rate_r):
    """Add a dry moment of `size` [N m] against turning, half of it under either wheel; each half acts as a damper below
    its own rate [rad/s].
    """
    add_contact(W, size, 0.0, 0.0, 1.0, rate_l, rate_r)


@njit(**ARITHMETIC)
def add_dry_friction(W, px, py, dx, dy, speed, size, inertia):
    """Add dry friction of `size` [N] at the point (px, py) [m] of `base` against `speed` [m/s] along the unit
    vector (dx, dy), as a place on the floor has it.

    A constant force while it cannot stop the motion within a few steps (second order), else a stiff damper: it creeps
    and lets go softly, so that a fit finds its way to places that hold the robot; `inertia` [kg] is the mass that it
    brakes, at least.
    """
    k = size / math.sqrt(speed * speed + CREEP_SPEED * CREEP_SPEED)
    if abs(speed) * inertia > STEPS_TO_STOP * W[STEP] * size:
        add_force(W, -k * speed * dx, -k * speed * dy, -k * speed * (px * dy - py * dx))
    else:
        add_oblique_damper(W, px, py, dx, dy, k)
