r"""The tyres slip (for a base whose tyres grip ideally, or with another tyre).

    s0 = slip_speed of the base + slip_speed

s0 [m/s]: slip at which a tyre passes 1/sqrt(2) of its grip; force over slip for small slips is mu N / s0, so
that the rim leads the floor by m s0 / (2 mu N) seconds times the acceleration. Source: slip stiffness,
Pacejka 2012, section 1.2.2.
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.effects.effect import Effect, Parameter
from fsm_calib.world2d.slots import SLIP_SPEED


@njit(error_model="numpy")
def soften(P, o, S, m, W):
    """Make the tyres softer."""
    W[SLIP_SPEED] += P[o]


EFFECT = Effect(
    name="wheel_slip",
    family="base",
    summary="softer tyres (where the base lets them grip ideally)",
    equation="s0 = base + slip_speed",
    parameters=(
        Parameter(
            "slip_speed",
            "s0",
            "m/s",
            0.0,
            0.0,
            0.5,
            0.05,
            "2 to 3 ms of tyre lag: 0.01 m/s",
            starts=(0.02, 0.1),
        ),
    ),
    hooks={"step": soften},
    channels=("forward", "lateral"),
    regimes=("transient", "fast_turn"),
    separates="rims turn faster than the floor passes, in proportion to the force",
    rivals=("lateral_slip", "low_friction_patch", "motor_asymmetric_lag"),
    manoeuvre="starts and stops at full command with encoders",
    sentence="The tyres slip by {slip_speed} at most of their grip.",
    source="Pacejka 2012, section 1.2.2",
    order=78,
    dissipative=True,
)
