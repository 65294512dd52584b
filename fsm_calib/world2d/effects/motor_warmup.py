r"""A motor changes its strength as it warms up, and levels off.

    T_i = K_i u_i (1 + change_i (1 - exp(-E_i / effort))),    dE_i/dt = (1 - idle) |u_i| + idle
    D_i = D / (1 + winding_i (1 - exp(-E_i / effort)))
    dh_i/dt = (|u_i| - h_i) / effort      in place of 1 - exp(-E_i / effort) where it cools, too

    R_i = 1 + heat q_i,    k_i = 1 - magnet heat q_i,    dq_i/dt = (j_i^2 R_i - q_i) / effort       by its current
    T_i -> T_i / k_i,    D_i -> D_i k_i^2 / R_i,         j_i = (u_i - k_i w_i / K_i) / R_i

T [m/s] no-load rim speed of wheel i, K [m/s] gain, u [1] command, E [s] seconds of full command since the
start of the recording, effort [s] after which 63 % of the change are done, change [1] of each wheel. Grease
thins (positive), windings heat (negative). idle [1]: 0 where the motor's own work heats it, 1 where what is on all
the time does (drivers and electronics beside it); then E is the time. winding [1]: a hot winding resists more
(copper: 0.4 % a kelvin), so that the slope D [N s/m] of the motor's torque falls while its no-load speed stays: it
lags more, and gives way more to friction; none resists less. What brakes the motor inside itself (brushes, bearings in
grease) then lowers its no-load speed, too. Nothing warms within a second or two: what acts so soon after a start is
another physics (a driver's ramp was called warm with 1.2 s).

heat [1]: how much of its resistance a winding gains if it stays at the stall current of full command, by the heat of
its current j [1, of that current], w [m/s] rim speed; q [1] the heat it holds, which it loses again within effort [s].
It grows warm where it speeds up, climbs and reverses, and hardly where it runs free. magnet [1]: the share of it by
which the magnets weaken meanwhile: 0.5 of ferrite (-0.2 % a kelvin), 0.25 of neodymium; the motor runs faster and pulls
less.
Source: first-order thermal model of a motor, Hughes & Drury, Electric Motors and Drives, 5th ed., section 11.3.
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.decay import gone
from fsm_calib.world2d.dynamics import GAIN
from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.effects.wheels import of_each_wheel
from fsm_calib.world2d.slots import COMMAND, DRIVE, RIM, STEP, TARGET


@njit(error_model="numpy")
def warm(P, o, S, m, W):
    """Change each wheel's target and slope by its effort so far, or by the heat of its current."""
    if P[o + 7] > 0.0:
        warm_by_current(P, o, S, m, W)
        return
    for side in range(2):
        heat = (1.0 - P[o + 3]) * abs(W[COMMAND + side]) + P[o + 3]
        if P[o + 6] > 0.0:
            gained = (heat - S[m + side]) * gone(W[STEP] / P[o + 2])
            warmed = S[m + side] + 0.5 * gained
        else:
            gained = heat * W[STEP]
            warmed = gone((S[m + side] + 0.5 * gained) / P[o + 2])
        W[TARGET + side] *= 1.0 + P[o + side] * warmed
        W[DRIVE + side] /= 1.0 + P[o + 4 + side] * warmed
        S[m + side] += gained


@njit(error_model="numpy")
def warm_by_current(P, o, S, m, W):
    """Let each winding take up the heat of its current, and change its motor's resistance and constant by it."""
    for side in range(2):
        growth = P[o + 7] * S[m + side]
        resistance, constant = 1.0 + growth, max(1.0 - P[o + 8] * growth, 0.3)
        current = (W[TARGET + side] - constant * S[RIM + side]) / (P[GAIN + side] * resistance)
        W[TARGET + side] /= constant
        W[DRIVE + side] *= constant * constant / resistance
        S[m + side] += (current * current * resistance - S[m + side]) * gone(W[STEP] / P[o + 2])


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
            3.0,
            120.0,
            6.0,
            "tens of seconds of driving",
            strength=False,
            floor=True,
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
                0.0,
                1.5,
                0.0,
                "copper: 0.2 to 0.4 for 50 to 100 K",
                starts=(0.25,),
            )
        ),
        Parameter(
            "cools", "k", "1", 0.0, 0.0, 1.0, 0.0, "1 where it cools in a drive", strength=False, fitted=False
        ),
        Parameter(
            "heat",
            "h",
            "1",
            0.0,
            0.0,
            60.0,
            0.0,
            "0.2 to 0.9 at a fifth of the stall current",
            starts=(3.0, 15.0),
        ),
        Parameter(
            "magnet",
            "m",
            "1",
            0.0,
            0.0,
            0.6,
            0.0,
            "ferrite 0.5, neodymium 0.25",
            strength=False,
            starts=(0.3,),
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
        Closure(
            "heat of the current",
            ("heat", "effort"),
            "both windings are heated by their currents, and cool",
            sentence="The windings' resistance grows {heat}-fold at the stall current, within {effort}.",
        ),
        Closure(
            "heat of the current, magnets too",
            ("heat", "magnet", "effort"),
            "both windings are heated by their currents, and the magnets weaken meanwhile",
            sentence="The windings' resistance grows {heat}-fold at the stall current, within {effort}; the magnets "
            "weaken by {magnet} of that.",
        ),
    ),
    memory=2,
    order=52,
)
