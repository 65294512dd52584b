r"""The caster drags, and kicks when it swivels.

    F_roll = -drag tanh-like(c) e,     c = e . v_p          (along the caster's own direction e)
    F_kick = -kick sgn-like(s) n,      s = n . v_p          (across it, while it is not yet aligned)
    d psi / dt = s / trail - omega

v_p [m/s] velocity of the caster's pivot, `CASTER_ARM` behind the axle; psi [rad] direction of the caster's wheel in
`base` (0: rolling straight ahead), e and n the unit vectors along and across it, trail [m] distance of its wheel behind
the pivot, drag and kick [N]. Aligned, s is zero and only the drag is left; after a reversal the wheel stands on the
wrong side of its pivot and turns over within a few trail lengths of travel, pushing sideways. Both laws are smooth
below the creep speed. Sources: rolling of a trailing wheel, Chung & Iagnemma, in Springer Handbook of Robotics, 2nd ed.
2016, section 24.1; Duckietown URDF for the arm (0.083 m).
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.dynamics import add_oblique_damper
from fsm_calib.world2d.effects.effect import Effect, Parameter
from fsm_calib.world2d.slots import CASTER_ARM, CREEP_SPEED, OMEGA, STEP, L, V

TRAIL = 0.02
"""Distance of the caster's wheel behind its pivot [m] (assumed; typical of 25 mm furniture casters)."""


@njit(error_model="numpy")
def drag_and_swivel(P, o, S, m, W):
    """Add the caster's forces as dampers and turn it; S[m] is psi."""
    vx, vy = S[V], S[L] - CASTER_ARM * S[OMEGA]
    c, s = math.cos(S[m]), math.sin(S[m])
    along, across = c * vx + s * vy, c * vy - s * vx
    roll = P[o] / math.sqrt(along * along + CREEP_SPEED * CREEP_SPEED)
    add_oblique_damper(W, -CASTER_ARM, 0.0, c, s, roll)
    kick = P[o + 1] / math.sqrt(across * across + SWIVEL_SPEED * SWIVEL_SPEED)
    add_oblique_damper(W, -CASTER_ARM, 0.0, -s, c, kick)
    turn = math.atan2(vy, vx)
    S[m] = turn_towards(S[m], turn, math.hypot(vx, vy) * W[STEP] / TRAIL, S[OMEGA] * W[STEP])


@njit(error_model="numpy")
def turn_towards(psi, turn, travel, body):
    """Return the caster's direction after `travel` trail lengths towards `turn` [rad] while the body turns by `body` [rad].

    The exact solution of d gap / d travel = -sin(gap): tan(gap / 2) decays exponentially.
    """
    gap = psi - turn
    gap -= 2.0 * math.pi * math.floor(gap / (2.0 * math.pi) + 0.5)
    if abs(gap) > math.pi - 1e-3:
        gap = math.copysign(math.pi - 1e-3, gap)
    return turn + 2.0 * math.atan(math.tan(0.5 * gap) * math.exp(-travel)) - body


SWIVEL_SPEED = 0.02
"""Speed across the caster at which its kick has 1/sqrt(2) of its size [m/s] (assumed)."""

EFFECT = Effect(
    name="caster_drag",
    family="resistance",
    summary="the caster drags, and kicks when it swivels",
    equation="F = -drag e sgn(e.v_p) - kick n sgn(n.v_p), dpsi/dt = n.v_p/trail - omega",
    parameters=(
        Parameter("drag", "F_c", "N", 0.0, 0.0, 4.0, 0.3, "2 to 10 % of the weight on it, more on carpet", starts=(0.2, 0.6)),
        Parameter("kick", "F_k", "N", 0.0, 0.0, 4.0, 0.0, "of the drag's size", starts=(0.3,)),
    ),
    hooks={"step": drag_and_swivel},
    channels=("forward", "turn"),
    regimes=("slow", "after_reversal", "fast_turn"),
    separates="acts behind the axle: it resists turning as well as driving, with a fixed ratio; kicks only after a reversal",
    rivals=("coulomb_friction", "tyre_scrub", "carpet_nap", "motor_deadband"),
    manoeuvre="forward and reverse, and spins at three rates",
    sentence="The caster drags with {drag} and kicks with up to {kick} when it swivels.",
    source="Springer Handbook of Robotics, 2nd ed. 2016, section 24.1; Duckietown URDF",
    variants=(("drag",), ("drag", "kick")),
    memory=1,
    order=75,
    dissipative=True,
)
