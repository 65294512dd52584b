r"""The supply sags: with the charge that was drawn, at once with the load, and slowly with a load that lasts.

    T = K u (1 - per_charge Q / (1 - emptying Q) - per_load I - polarised I_R) f
    I = |u_l| + |u_r|,    dQ/dt = I + idle,    dI_R/dt = (I - I_R) / relaxation
    f = 1 - inner sum_i max(0, u_i^2 (f - w_i / T_i))

T [m/s] no-load rim speed, K [m/s] gain, u [1] commands, Q [s] seconds of full command drawn by both motors since the
start of the recording, per_charge [1/s], per_load [1], polarised [1] with its time constant relaxation [s]. A cell
near its end loses ever more by what is drawn: emptying [1/s] is one over the Q that would empty it; and a computer
that draws as much as the motors do empties it at rest, too: idle [1] is its current, one motor's full command being
1. `inner` [1] is the cell's resistance over a motor's: the drop by the current that the bridges draw, in stall
currents, which is large while a motor speeds up or climbs and small while it runs free, w_i [m/s] rim speed; none
flows back. Both wheels alike. None of the three is negative, as no cell gains by what is drawn from it: motors that
grow stronger as they are driven have grease that thins (`motor_warmup`). Sources: the polarisation K Q_0 / (Q_0 - Q)
of Shepherd, Design of primary and secondary cells, J. Electrochem. Soc. 112 (1965) 657; Thevenin cell with one RC
branch, e.g. Plett, Battery Management Systems I, 2015, sections 2.2 and 2.3; a bridge draws the motor's current for
its on time, as in Mohan, Undeland & Robbins, Power Electronics, 3rd ed. 2003, section 7.7.
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.decay import gone
from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.slots import COMMAND, RIM, STEP, TARGET

LEAST_LEFT = 0.05  # of a cell's charge: what is drawn beyond takes no more of its strength


@njit(error_model="numpy")
def sag(P, o, S, m, W):
    """Lower both targets, count the charge, and let the cell polarise."""
    load = abs(W[COMMAND]) + abs(W[COMMAND + 1])
    share = gone(W[STEP] / P[o + 3])
    lasting = S[m + 1] + 0.5 * share * (load - S[m + 1])
    drawn = (load + P[o + 6]) * W[STEP]
    charge = S[m] + 0.5 * drawn
    dip = P[o] * charge / max(1.0 - P[o + 5] * charge, LEAST_LEFT) + P[o + 1] * load + P[o + 2] * lasting
    factor = max(1.0 - dip, 0.0)
    S[m] += drawn
    S[m + 1] += share * (load - S[m + 1])
    if P[o + 4] > 0.0:
        factor *= under_current(S, W, P[o + 4])
    W[TARGET] *= factor
    W[TARGET + 1] *= factor


@njit(error_model="numpy")
def under_current(S, W, inner):
    """Return the supply's strength [1] under what the motors draw at their rim speeds."""
    drawn, back = 0.0, 0.0
    for side in range(2):
        target = W[TARGET + side]
        turned = S[RIM + side] / target if target != 0.0 else 1.0
        if turned < 1.0:  # the motor pushes; one that brakes draws nothing
            square = W[COMMAND + side] * W[COMMAND + side]
            drawn += square
            back += square * turned
    return max((1.0 + inner * back) / (1.0 + inner * drawn), 0.0)


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
            0.0,
            0.02,
            0.004,
            "3 to 10 % in a run of some minutes",
            starts=(0.004,),
        ),
        Parameter("per_load", "rho", "1", 0.0, 0.0, 0.3, 0.03, "1 to 5 % at full load", starts=(0.05,)),
        Parameter("polarised", "rho_R", "1", 0.0, 0.0, 0.3, 0.0, "as much again as per_load", starts=(0.05,)),
        Parameter(
            "relaxation",
            "tau_R",
            "s",
            10.0,
            1.0,
            120.0,
            10.0,
            "seconds to a minute",
            strength=False,
            starts=(4.0, 15.0),
        ),
        Parameter(
            "inner",
            "R_i/R_m",
            "1",
            0.0,
            0.0,
            2.0,
            0.0,
            "cells of 0.1 to 0.5 ohm, motors of 1 to 5",
            starts=(0.1, 0.4),
        ),
        Parameter(
            "emptying",
            "1/Q_0",
            "1/s",
            0.0,
            0.0,
            0.1,
            0.0,
            "empty after one to five minutes of driving",
            strength=False,
            starts=(0.008,),
        ),
        Parameter(
            "idle",
            "I_0",
            "1",
            0.0,
            0.0,
            6.0,
            0.0,
            "a computer of 5 to 10 W beside motors of 2 to 20",
            strength=False,
            starts=(0.5,),
        ),
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
        Closure(
            "near its end",
            ("per_charge", "emptying", "idle"),
            "falls ever faster as it is emptied, by the computer, too",
            sentence="The supply loses {per_charge} of its strength for each second of one motor's full command, and "
            "more the emptier it is.",
        ),
        Closure("charge and load", ("per_charge", "per_load"), "and dips while both motors draw"),
        Closure(
            "load that lasts",
            ("per_load", "polarised", "relaxation"),
            "dips at once and goes on dipping for a while, and comes back",
            sentence="A load takes {per_load} of the supply's strength at once and {polarised} within {relaxation}.",
        ),
        Closure(
            "inner resistance",
            ("inner",),
            "dips by the current that the motors draw",
            sentence="The supply has {inner} of a motor's resistance.",
        ),
        Closure(
            "charge and resistance",
            ("per_charge", "inner"),
            "falls with the charge drawn, and dips by the current",
        ),
    ),
    memory=2,
    order=50,
)
