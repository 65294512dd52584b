r"""The tyres' wide contact resists turning.

    M = -moment omega / sqrt(omega^2 + creep^2)

M [N m] about the vertical, omega [rad/s] yaw rate, creep [rad/s] rate below which it acts as a stiff damper: half the
contact's length times friction times load for each wheel. Source: Pacejka, Tyre and Vehicle Dynamics, 3rd ed. 2012,
section 9.2 (turn slip and parking torque).
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.effects.effect import Effect, Parameter
from fsm_calib.world2d.slots import CREEP_RATE, DAMP, OMEGA


@njit(error_model="numpy")
def scrub(P, o, S, m, W):
    """Add the resistance as a damper of the yaw rate."""
    W[DAMP + 5] += P[o] / math.sqrt(S[OMEGA] * S[OMEGA] + CREEP_RATE * CREEP_RATE)


EFFECT = Effect(
    name="tyre_scrub",
    family="resistance",
    summary="resistance to turning",
    equation="M = -moment sgn(omega)",
    parameters=(Parameter("moment", "M_s", "N m", 0.0, 0.0, 0.5, 0.02, "contact 5 to 10 mm wide under 5 N", starts=(0.01, 0.04)),),
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
