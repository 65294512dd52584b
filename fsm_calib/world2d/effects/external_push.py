r"""Somebody or something pushes the robot once, at a blow or for as long as a hand leans on it.

    F = (impulse_x, impulse_y) / duration,  M = impulse_turn / duration      start <= t < start + duration

F [N] in `world` at the axle centre, M [N m], impulses [N s] and [N m s], start and duration [s]. Source:
momentum balance.
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.effects.places import overlap
from fsm_calib.world2d.forces import add_force
from fsm_calib.world2d.slots import COS, SIN, STEP, TIME


@njit(error_model="numpy")
def push(P, o, S, m, W):
    """Add the push for the part of the step that it covers."""
    part = overlap(S[TIME], S[TIME] + W[STEP], P[o + 3], P[o + 3] + P[o + 4]) / P[o + 4]
    fx, fy = part * P[o], part * P[o + 1]
    add_force(W, W[COS] * fx + W[SIN] * fy, W[COS] * fy - W[SIN] * fx, part * P[o + 2])


EFFECT = Effect(
    name="external_push",
    family="event",
    summary="one push from outside",
    equation="F = impulse / duration from start",
    parameters=(
        Parameter(
            "impulse_x", "J_x", "N s", 0.0, -40.0, 40.0, 0.4, "a nudge: 0.2 to 1 N s", per_recording=True
        ),
        Parameter(
            "impulse_y", "J_y", "N s", 0.0, -40.0, 40.0, 0.2, "a nudge", per_recording=True, mirror="negate"
        ),
        Parameter(
            "impulse_turn",
            "J_w",
            "N m s",
            0.0,
            -4.0,
            4.0,
            0.02,
            "a nudge",
            per_recording=True,
            mirror="negate",
        ),
        Parameter(
            "start", "t0", "s", 0.0, -1.0, 1e5, 7.15, "any", strength=False, per_recording=True, step=5e-3
        ),
        Parameter(
            "duration",
            "dt",
            "s",
            0.2,
            0.02,
            8.0,
            0.2,
            "0.1 to 0.4 s; a hand stays for seconds",
            strength=False,
            per_recording=True,
            step=5e-3,
        ),
    ),
    hooks={"step": push},
    reads=("heading",),
    channels=("forward", "lateral", "turn"),
    regimes=("once", "heading"),
    separates="once, within a fraction of a second, whatever the command",
    rivals=("motor_fault", "low_friction_patch", "misplaced_marker"),
    manoeuvre="repeat the drive: a push does not come back",
    sentence="At {start} something pushed the robot by ({impulse_x}, {impulse_y}).",
    source="momentum balance",
    closures=(
        Closure("push", ("impulse_x", "impulse_y", "impulse_turn", "start"), "impulse and moment at once"),
        Closure(
            "held",
            ("impulse_x", "impulse_y", "impulse_turn", "start", "duration"),
            "a force that lasts",
            sentence="From {start} something pushed the robot for {duration} by ({impulse_x}, {impulse_y}) in all.",
        ),
    ),
    when="moment",
    acts_on="push",
    order=86,
)
