r"""One motor is stronger than the other (for a base that assumes them equal).

    T_l = K u_l (1 - imbalance),    T_r = K u_r (1 + imbalance)

T [m/s] no-load rim speeds, K [m/s] the common gain, imbalance [1] = (ratio - 1) / (ratio + 1) with the ratio
of right to left gain. Source: 32 real Duckiebots have ratios of 0.78 to 1.19 (calibration logs in dt-core).
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.effects.effect import Effect, Parameter
from fsm_calib.world2d.slots import TARGET


@njit(error_model="numpy")
def unbalance(P, o, S, m, W):
    """Scale the two targets against each other."""
    W[TARGET] *= 1.0 - P[o]
    W[TARGET + 1] *= 1.0 + P[o]


EFFECT = Effect(
    name="unequal_motors",
    family="base",
    summary="one motor is stronger (where the base assumes them equal)",
    equation="T_l = K u_l (1 - imbalance), T_r = K u_r (1 + imbalance)",
    parameters=(
        Parameter("imbalance", "delta", "1", 0.0, -0.6, 0.6, 0.05, "sd 0.05 over 32 robots", mirror="negate"),
    ),
    hooks={"step": unbalance},
    channels=("turn",),
    regimes=("driving",),
    separates="turns in proportion to the speed, forwards and backwards, on every heading",
    rivals=("floor_tilt", "motor_fault"),
    manoeuvre="a straight forwards and backwards",
    sentence="The right motor is stronger: imbalance {imbalance}.",
    source="Duckietown calibration logs",
    order=48,
)
