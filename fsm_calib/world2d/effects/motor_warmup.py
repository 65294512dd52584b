r"""A motor changes its strength as it warms up, and levels off.

    T_i = K_i u_i (1 + change_i (1 - exp(-E_i / effort))),    dE_i/dt = (1 - idle) |u_i| + idle
    D_i = D / (1 + winding_i (1 - exp(-E_i / effort)))
    dh_i/dt = (|u_i| - h_i) / effort      in place of 1 - exp(-E_i / effort) where it cools, too

T [m/s] no-load rim speed of wheel i, K [m/s] gain, u [1] command, E [s] seconds of full command since the
start of the recording, effort [s] after which 63 % of the change are done, change [1] of each wheel. Grease
thins (positive), windings heat (negative). idle [1]: 0 where the motor's own work heats it, 1 where what is on all
the time does (drivers and electronics beside it); then E is the time. winding [1]: a hot winding resists more
(copper: 0.4 % a kelvin), so that the slope D [N s/m] of the motor's torque falls while its no-load speed stays: it
lags more, and gives way more to friction. What brakes the motor inside itself (brushes, bearings in grease) then lowers
its no-load speed, too. Source: first-order thermal model of a motor,
Hughes & Drury, Electric Motors and Drives, 5th ed., section 11.3.
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.effects.wheels import of_each_wheel
from fsm_calib.world2d.slots import COMMAND, DRIVE, STEP, TARGET


@njit(error_model="numpy")
def warm(P, o, S, m, W):
    """Change each wheel's target and slope by its effort so far."""
    for side in range(2):
        heat = (1.0 - P[o + 3]) * abs(W[COMMAND + side]) + P[o + 3]
        if P[o + 6] > 0.0:
            gained = (heat - S[m + side]) * -math.expm1(-W[STEP] / P[o + 2])
            warmed = S[m + side] + 0.5 * gained
        else:
            gained = heat * W[STEP]
            warmed = -math.expm1(-(S[m + side] + 0.5 * gained) / P[o + 2])
        W[TARGET + side] *= 1.0 + P[o + side] * warmed
        W[DRIVE + side] /= 1.0 + P[o + 4 + side] * warmed
        S[m + side] += gained


EFFECT = Effect(
    name="motor_warmup",
    family="drift",
    summary="a motor's strength changes as it warms up",
    equation="T_i = K_i u_i (1 + change_i (1 - exp(-E_i/effort)))",
    parameters=(
        Parameter(
            "change_left", "a_l", "1", 0.0, -0.35, 0.35, -0.08, "2 to 10 %", mirror="swap:change_right"
        ),
        Parameter("change_right", "a_r", "1", 0.0, -0.35, 0.35, 0.06, "2 to 10 %", mirror="swap:change_left"),
        Parameter(
            "effort",
            "E0",
            "s",
            20.0,
            0.5,
            120.0,
            6.0,
            "tens of seconds of driving",
            strength=False,
            starts=(3.0, 10.0, 25.0),
        ),
        Parameter(
            "idle",
            "w_i",
            "1",
            0.0,
            0.0,
            1.0,
            0.0,
            "0 heated by its work, 1 by what is always on",
            strength=False,
            fitted=False,
            starts=(0.0, 1.0),
        ),
        *of_each_wheel(
            Parameter(
                "winding",
                "r",
                "1",
                0.0,
                -0.4,
                1.5,
                0.0,
                "copper: 0.2 to 0.4 for 50 to 100 K",
                starts=(0.25,),
            )
        ),
        Parameter(
            "cools", "k", "1", 0.0, 0.0, 1.0, 0.0, "1 where it cools in a drive", strength=False, fitted=False
        ),
    ),
    hooks={"step": warm},
    channels=("forward", "turn"),
    regimes=("early", "one_wheel"),
    separates="levels off, and may be one wheel's alone; a sagging battery goes on and takes both",
    rivals=("battery_sag", "motor_fault"),
    manoeuvre="a long drive with a pause, then the first straight again",
    sentence="Warming up changes the left motor by {change_left} and the right one by {change_right}.",
    input="command",
    source="Hughes & Drury, Electric Motors and Drives, 5th ed., section 11.3",
    closures=(
        Closure("left motor", ("change_left",), "the left motor alone, effort as is usual"),
        Closure("right motor", ("change_right",), "the right motor alone, effort as is usual"),
        Closure("left motor, own effort", ("change_left", "effort"), "the left motor alone"),
        Closure("right motor, own effort", ("change_right", "effort"), "the right motor alone"),
        Closure("both motors", ("change_left", "change_right", "effort"), "each by its own share"),
        Closure(
            "both motors, cooling",
            ("change_left", "change_right", "effort"),
            "each by its own share, and cooling while it rests",
            fixes={"cools": 1.0},
        ),
        Closure(
            "left winding",
            ("winding_left", "effort"),
            "the left motor's resistance grows",
            sentence="The left motor's resistance grows by {winding_left} as it warms up.",
        ),
        Closure(
            "right winding",
            ("winding_right", "effort"),
            "the right motor's resistance grows",
            sentence="The right motor's resistance grows by {winding_right} as it warms up.",
        ),
        Closure(
            "both windings",
            ("winding_left", "winding_right", "effort"),
            "both motors' resistances grow",
            sentence="Warming up adds {winding_left} (left) and {winding_right} (right) to the motors' resistances.",
        ),
        Closure(
            "both windings, speeds too",
            ("change_left", "change_right", "winding_left", "winding_right", "effort"),
            "both motors' resistances grow, and what brakes them slows them down by so much more",
            sentence="Warming up adds {winding_left} (left) and {winding_right} (right) to the motors' resistances and "
            "changes their speeds by {change_left} and {change_right}.",
        ),
    ),
    memory=2,
    order=52,
)
