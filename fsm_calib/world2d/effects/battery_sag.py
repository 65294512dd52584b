r"""The supply sags: with the charge that was drawn, and at once with the load.

    T = K u (1 - per_charge Q - per_load (|u_l| + |u_r|)),    dQ/dt = |u_l| + |u_r|

T [m/s] no-load rim speed, K [m/s] gain, u [1] commands, Q [s] seconds of full command drawn by both motors
since the start of the recording, per_charge [1/s], per_load [1]. Both wheels alike. Source: Thevenin cell,
e.g. Plett, Battery Management Systems I, 2015, section 2.2.
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.slots import COMMAND, STEP, TARGET


@njit(error_model="numpy")
def sag(P, o, S, m, W):
    """Lower both targets and count the charge."""
    load = abs(W[COMMAND]) + abs(W[COMMAND + 1])
    factor = max(1.0 - P[o] * (S[m] + 0.5 * load * W[STEP]) - P[o + 1] * load, 0.0)
    S[m] += load * W[STEP]
    W[TARGET] *= factor
    W[TARGET + 1] *= factor


EFFECT = Effect(
    name="battery_sag",
    family="drift",
    summary="both motors weaken with the charge drawn and the load",
    equation="T = K u (1 - per_charge Q - per_load sum|u|)",
    parameters=(
        Parameter(
            "per_charge",
            "beta",
            "1/s",
            0.0,
            -0.002,
            0.02,
            0.004,
            "3 to 10 % in a run of some minutes",
            starts=(0.004,),
        ),
        Parameter("per_load", "rho", "1", 0.0, -0.1, 0.3, 0.03, "1 to 5 % at full load", starts=(0.05,)),
    ),
    hooks={"step": sag},
    channels=("forward", "turn"),
    regimes=("late", "large_command"),
    separates="both wheels alike and ever on; warming up levels off and may be one wheel's",
    rivals=("motor_warmup", "motor_fault", "motor_gain_curve"),
    manoeuvre="a long drive with a pause, then the first straight again",
    sentence="The supply loses {per_charge} of its strength for each second of one motor's full command.",
    input="command",
    source="Plett, Battery Management Systems I, 2015, section 2.2",
    closures=(
        Closure("charge alone", ("per_charge",), "the voltage falls with the charge drawn"),
        Closure("charge and load", ("per_charge", "per_load"), "and dips while both motors draw"),
    ),
    memory=1,
    order=50,
)
