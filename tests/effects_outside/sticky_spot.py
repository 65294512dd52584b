r"""A sticky spot: tape or spilt sugar holds each wheel back, the more the slower it rolls.

    F_i = -pull / (1 + |v_i| / rate) sgn(v_i)        |p_i - (x, y)| <= radius

F [N] on wheel i, whose contact p_i [m] in `world` moves with v_i [m/s]; pull [N], rate [m/s], centre (x, y) and
radius [m] of a disc. Source: made up for the tests (adhesion that does not keep up with the speed).
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.effects.effect import Effect, Parameter
from fsm_calib.world2d.effects.places import centre_parameters, contact_arm, contact_place, in_disc
from fsm_calib.world2d.forces import add_dry_friction
from fsm_calib.world2d.slots import MASS, OMEGA, V


@njit(error_model="numpy")
def stick(P, o, S, m, W):
    """Hold back each wheel inside."""
    for side in range(2):
        arm = contact_arm(W, side, 1.0)
        x, y = contact_place(W, arm)
        speed = S[V] - arm * S[OMEGA]
        pull = P[o] * in_disc(x, y, P[o + 1], P[o + 2], P[o + 3]) / (1.0 + abs(speed) / P[o + 4])
        add_dry_friction(W, 0.0, arm, 1.0, 0.0, speed, pull, 0.5 * W[MASS])


EFFECT = Effect(
    name="sticky_spot",
    family="patch",
    summary="a sticky spot",
    equation="F_i = -pull / (1 + |v_i|/rate) sgn(v_i) inside a disc",
    parameters=(
        Parameter("pull", "F_s", "N", 0.0, 0.0, 8.0, 1.2, "tape", starts=(0.7, 2.0)),
        *centre_parameters("k", doubt=0.03),
        Parameter("radius", "r_k", "m", 0.2, 0.03, 3.0, 0.2, "a hand", strength=False, step=6e-3),
        Parameter("rate", "v_k", "m/s", 0.1, 0.01, 1.0, 0.1, "assumed", strength=False, fitted=False),
    ),
    hooks={"step": stick},
    channels=("forward", "turn"),
    regimes=("place",),
    separates="only there, and more at low speed; a rough spot resists alike at every speed",
    rivals=("rough_floor_patch", "low_friction_patch", "misplaced_marker"),
    manoeuvre="cross the place at two speeds",
    sentence="Within {radius} of ({x}, {y}) the floor sticks to each wheel with {pull}.",
    source="made up for the tests",
    where="disc",
    reads=("place", "heading"),
    order=85,
    dissipative=True,
)
