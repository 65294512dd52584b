r"""The tyres' wide contact resists turning.

    M = -moment omega / sqrt(omega^2 + creep^2)

M [N m] about the vertical, omega [rad/s] yaw rate, creep [rad/s] rate below which it acts as a stiff damper:
half the contact's length times friction times load for each wheel. Source: Pacejka, Tyre and Vehicle
Dynamics, 3rd ed. 2012, section 9.2 (turn slip and parking torque).
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.effects.effect import Effect, Parameter
from fsm_calib.world2d.forces import STEPS_TO_STOP, add_force
from fsm_calib.world2d.slots import CREEP_RATE, DAMP, INERTIA, OMEGA, STEP


@njit(error_model="numpy")
def scrub(P, o, S, m, W):
    """Add the moment; near standstill as a damper of the yaw rate."""
    k = P[o] / math.sqrt(S[OMEGA] * S[OMEGA] + CREEP_RATE * CREEP_RATE)
    if abs(S[OMEGA]) * W[INERTIA] > STEPS_TO_STOP * W[STEP] * P[o]:
        add_force(W, 0.0, 0.0, -k * S[OMEGA])
    else:
        W[DAMP + 5] += k


EFFECT = Effect(
    name="tyre_scrub",
    family="resistance",
    summary="resistance to turning",
    equation="M = -moment sgn(omega)",
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
    ),
    hooks={"step": scrub},
    channels=("turn",),
    regimes=("turning",),
    separates="turning alone suffers, by the same moment at every rate; a longer axle scales with the rate",
    rivals=("coulomb_friction", "caster_drag", "motor_deadband", "lateral_slip"),
    manoeuvre="spins at three rates and wide arcs",
    sentence="The tyres resist turning with {moment}.",
    source="Pacejka 2012, section 9.2",
    order=76,
    dissipative=True,
)
