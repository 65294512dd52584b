r"""One motor is stronger than the other (for a base that assumes them equal).

    T_l = K u_l (1 - imbalance),    T_r = K u_r (1 + imbalance)
    D_l = D (1 - stiffness),        D_r = D (1 + stiffness)

T [m/s] no-load rim speeds, K [m/s] the common gain, imbalance [1] = (ratio - 1) / (ratio + 1) with the ratio
of right to left gain. D [N s/m] slopes of the motors' force at the rim, stiffness [1] half of their difference over
their mean. The slope is the motor's constant squared over its resistance: of motors of one kind the constants differ
by 5 %, the resistances by 4 % (assumed: data sheets allow 10 %), the slopes by 11 %. Source: 32 real Duckiebots have
ratios of 0.78 to 1.19 (calibration logs in dt-core); the slope: Hughes & Drury, Electric Motors and Drives, 4th ed.,
chapter 3.
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.effects.effect import Effect, Parameter
from fsm_calib.world2d.slots import DRIVE, TARGET


@njit(error_model="numpy")
def unbalance(P, o, S, m, W):
    """Scale the two targets, and the two slopes, against each other."""
    W[TARGET] *= 1.0 - P[o]
    W[TARGET + 1] *= 1.0 + P[o]
    W[DRIVE] *= 1.0 - P[o + 1]
    W[DRIVE + 1] *= 1.0 + P[o + 1]


EFFECT = Effect(
    name="unequal_motors",
    family="base",
    summary="one motor is stronger (where the base assumes them equal)",
    equation="T_l = K u_l (1 - imbalance), T_r = K u_r (1 + imbalance)",
    parameters=(
        Parameter("imbalance", "delta", "1", 0.0, -0.6, 0.6, 0.05, "sd 0.05 over 32 robots", mirror="negate"),
        Parameter(
            "stiffness",
            "rho",
            "1",
            0.0,
            -0.4,
            0.4,
            0.0,
            "constants differ by 5 %, resistances by 4 %",
            mirror="negate",
            prior=0.06,
        ),
    ),
    hooks={"step": unbalance},
    channels=("turn",),
    regimes=("driving",),
    separates="turns in proportion to the speed, forwards and backwards, on every heading",
    rivals=(
        "floor_tilt",
        "motor_fault",
        "payload_offset",
        "motor_asymmetric_lag",
        "motor_warmup",
        "motor_deadband",
        "motor_reverse_asymmetry",
        "motor_gain_curve",
        "coulomb_friction",
        "gear_backlash",
    ),
    manoeuvre="a straight forwards and backwards",
    sentence="The right motor is stronger: imbalance {imbalance}.",
    source="Duckietown calibration logs",
    order=48,
)
