r"""The tyres' wide contact resists turning.

    M = -moment omega / sqrt(omega^2 + rate^2)

M [N m] about the vertical: half the contact's length times friction times load for each wheel; omega [rad/s] yaw
rate; rate [rad/s] below which it acts as a damper: a turning contact slides as a whole only when it turns faster
than its tread can bend and roll off. Source: Pacejka, Tyre and Vehicle Dynamics, 3rd ed. 2012, section 9.2 (turn
slip and parking torque).
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.forces import STEPS_TO_STOP, add_force
from fsm_calib.world2d.slots import CREEP_RATE, DAMP, INERTIA, OMEGA, STEP


@njit(error_model="numpy")
def scrub(P, o, S, m, W):
    """Add the moment; near standstill as a damper of the yaw rate."""
    k = P[o] / math.sqrt(S[OMEGA] * S[OMEGA] + P[o + 1] * P[o + 1])
    if abs(S[OMEGA]) * W[INERTIA] > STEPS_TO_STOP * W[STEP] * P[o]:
        add_force(W, 0.0, 0.0, -k * S[OMEGA])
    else:
        W[DAMP + 5] += k


EFFECT = Effect(
    name="tyre_scrub",
    family="resistance",
    summary="resistance to turning",
    equation="M = -moment omega / sqrt(omega^2 + rate^2)",
    parameters=(
        Parameter(
            "moment",
            "M_s",
            "N m",
            0.0,
            0.0,
            0.5,
            0.02,
            "contact 5 to 10 mm wide under 5 N",
            starts=(0.01, 0.04),
        ),
        Parameter(
            "rate",
            "w_s",
            "rad/s",
            CREEP_RATE,
            CREEP_RATE,
            1.0,
            0.1,
            "0.01 (sliding at once) to 0.3 for soft treads",
            strength=False,
            step=5e-3,
            starts=(0.1,),
        ),
    ),
    hooks={"step": scrub},
    channels=("turn",),
    regimes=("turning",),
    separates="turning alone suffers, by the same moment at every rate; a longer axle scales with the rate",
    rivals=("coulomb_friction", "caster_drag", "motor_deadband", "lateral_slip"),
    manoeuvre="spins at three rates and wide arcs",
    sentence="The tyres resist turning with {moment}.",
    source="Pacejka 2012, section 9.2",
    closures=(
        Closure("usual tread", ("moment",), "slides as a whole from 0.01 rad/s on"),
        Closure("own tread", ("moment", "rate"), "a tread that bends and rolls off first"),
    ),
    order=76,
    dissipative=True,
    universal=True,
)
