r"""Slowing down takes another time than speeding up.

    F = D (T - w) a,    a = 1 where the motor drives, a = 1 / ratio where it brakes ((T - w) w < 0)
    T' = (T_command - T) / tau,    tau = rise where the command's size grows, fall where it shrinks or turns over
    |T_s'| <= 1 / ramp,  ramp = ramp_up where the size grows, ramp_down where it shrinks or turns over

F [N] at the rim, D [N s/m], T no-load and w actual rim speed [m/s]; ratio [1] = time constant of slowing down
over that of speeding up: above 1 for a driver that lets the motor coast, below 1 for one that shorts it. It may
be one motor's alone (r_l, r_r). The change is spread over 1 cm/s around standstill and no-load. A driver may instead
let its output follow the command with a time constant upwards (rise [s]), downwards (fall [s]) or both ways (a filter
of set points): then the motor's own lag comes on top. Or the set point T_s may change by so much in a second at most:
ramp [s2/m] is the time for each m/s. Firmware limits what its loop is asked for, so a controller of speed follows the
limited set point, where there is one; a filter acts behind it (before a loop without feed-forward it would do what dry
friction does against it). Either is of both motors or of the one that ramp_side tells; a filter may have
a time constant of its own on each side, both ways (lag_l, lag_r [s]). Sources: H-bridge decay modes, e.g. TI DRV8833
data sheet, section 7.3.2; acceleration and deceleration ramps, e.g. Roboteq Controllers User Manual v2.1, "Acceleration
and Deceleration"; a first-order filter of set points, Astrom & Hagglund, Advanced PID Control, 2006, section 5.3.
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.decay import gone
from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.effects.wheels import is_the_others, of_each_wheel, of_one_driver_or_both
from fsm_calib.world2d.slots import DRIVE, RIM, STEP, TARGET

OF_BOTH = {"ramp_side": 0.0}
"""Where no driver is slow the side is told by nothing."""
LEAST_LAG = 0.035
"""Time constant [s]: a loop of 20 Hz is 25 ms late in the mean and a winding up to 10 ms, and two motors' own, of 0.1
to 0.4 s, differ by as much (5 to 10 %) where no driver is slow."""
LEAST_RAMP = 0.05
"""Time for each m/s [s2/m]: at a small robot's 0.4 m/s no more than the base's lag is off by."""
SOFT = 0.01
"""Speed over which driving turns into braking [m/s] (assumed)."""


@njit(error_model="numpy")
def filtered(before, wanted, tau, time):
    """Return a first-order filter's integral over a time [s] and its value after it, for a constant input."""
    if tau <= 0.0:
        return wanted * time, wanted
    share = gone(time / tau)
    return wanted * time + (before - wanted) * share * tau, before + (wanted - before) * share


@njit(error_model="numpy")
def follow(before, wanted, rise, fall, step):
    """Return the driver's mean output over a step [s] and its output after it: down by `fall`, up by `rise` [s]."""
    crosses = wanted * before < 0.0
    shrinks = crosses or abs(wanted) < abs(before)
    down = step if shrinks else 0.0
    if crosses:
        down = min(fall * math.log1p(-before / wanted), step)
    area, value = filtered(before, wanted, fall, down) if shrinks else (0.0, before)
    if down < step:
        rest, value = filtered(0.0 if crosses else value, wanted, rise, step - down)
        area += rest
    return area / step, value


@njit(error_model="numpy")
def towards(before, wanted, ramp, time):
    """Return how long it takes to get from a value to another, `time` at most, and the value then; ramp [s2/m]."""
    needed = abs(wanted - before) * ramp
    if needed <= time:
        return needed, wanted
    return time, before + math.copysign(time / ramp, wanted - before)


@njit(error_model="numpy")
def ramped(before, wanted, up, down, step):
    """Return a limited driver's mean output over a step [s] and its output after it: `up` and `down` [s2/m]."""
    crosses = wanted * before < 0.0
    shrinks = crosses or abs(wanted) < abs(before)
    spent, value = towards(before, 0.0 if crosses else wanted, down, step) if shrinks else (0.0, before)
    area = 0.5 * (before + value) * spent
    if value != wanted and spent < step:
        rising, after = towards(value, wanted, up, step - spent)
        area += 0.5 * (value + after) * rising
        spent, value = spent + rising, after
    return (area + value * (step - spent)) / step, value


@njit(error_model="numpy")
def is_limited(P, o):
    """Return whether set points may change by so much in a second at most."""
    return P[o + 5] > 0.0 or P[o + 6] > 0.0


@njit(error_model="numpy")
def limit(P, o, S, m, W):
    """Let the set points change by what the limits allow, before a controller of speed follows them."""
    if not is_limited(P, o):
        return
    for side in range(2):
        wanted = W[TARGET + side]
        if is_the_others(P[o + 7], side):
            S[m + side] = wanted
        else:
            W[TARGET + side], S[m + side] = ramped(S[m + side], wanted, P[o + 5], P[o + 6], W[STEP])


@njit(error_model="numpy")
def follow_late(P, o, S, m, W):
    """Let the drivers follow the commands through their filters."""
    for side in range(2):
        wanted, lag = W[TARGET + side], P[o + 8 + side]
        if is_the_others(P[o + 7], side):
            S[m + side] = wanted
        else:
            rise, fall = P[o + 3] + lag, P[o + 4] + lag
            W[TARGET + side], S[m + side] = follow(S[m + side], wanted, rise, fall, W[STEP])


@njit(error_model="numpy")
def brake(P, o, S, m, W):
    """Let the drivers follow what they are given, and scale the motors' slope where they brake."""
    if not is_limited(P, o):
        follow_late(P, o, S, m, W)
    for side in range(2):
        rim = S[RIM + side]
        against = (W[TARGET + side] - rim) * rim
        share = 0.5 - 0.5 * against / math.sqrt(against * against + SOFT**4)
        W[DRIVE + side] *= 1.0 + share * (1.0 / (P[o] * P[o + 1 + side]) - 1.0)


def _ramp(name: str, symbol: str) -> Parameter:
    """Return a time constant of the drivers; below `LEAST_LAG` it is how one motor differs from the other."""
    return Parameter(
        name, symbol, "s", 0.0, 0.0, 1.5, 0.0, "driver ramps: 0.05 to 0.5", starts=(0.05, 0.2), least=LEAST_LAG,
        in_series=True,
    )  # fmt: skip


def _limit(way: str, symbol: str) -> Parameter:
    """Return the time that the drivers take for each m/s; nothing below what a small robot's base hides."""
    return Parameter(
        f"ramp_{way}", symbol, "s2/m", 0.0, 0.0, 10.0, 0.0, "limits of 0.3 to 3 m/s2", starts=(0.4, 1.5),
        least=LEAST_RAMP,
    )  # fmt: skip


EFFECT = Effect(
    name="motor_asymmetric_lag",
    family="timing",
    summary="slowing down takes another time than speeding up",
    equation="F = D (T - w) / ratio while braking",
    parameters=(
        Parameter(
            "ratio", "r", "1", 1.0, 0.2, 5.0, 1.6, "coast against brake: 1.3 to 2.5", starts=(0.7, 1.5)
        ),
        *of_each_wheel(
            Parameter(
                "ratio",
                "r",
                "1",
                1.0,
                0.2,
                5.0,
                1.0,
                "one channel of the driver set otherwise",
                starts=(0.7, 1.5),
            )
        ),
        _ramp("rise", "tau_u"),
        _ramp("fall", "tau_d"),
        _limit("up", "b_u"),
        _limit("down", "b_d"),
        of_one_driver_or_both("ramp_side", "s"),
        *of_each_wheel(_ramp("lag", "tau")),
    ),
    hooks={"set_point": limit, "step": brake},
    channels=("forward", "turn"),
    regimes=("transient", "stopping"),
    separates="shows after steps down and not after steps up; a delay shows after both",
    rivals=("command_delay", "coulomb_friction", "gear_backlash"),
    manoeuvre="starts and stops at three speeds",
    sentence="Slowing down takes {ratio} times as long as speeding up.",
    source="TI DRV8833 data sheet, decay modes",
    input="command",
    closures=(
        Closure("both alike", ("ratio",), "the same in both motors", fixes=OF_BOTH),
        Closure(
            "left wheel",
            ("ratio_left",),
            "of the left motor alone",
            sentence="The left motor takes {ratio_left} times as long to slow down as to speed up.",
            fixes=OF_BOTH,
        ),
        Closure(
            "right wheel",
            ("ratio_right",),
            "of the right motor alone",
            sentence="The right motor takes {ratio_right} times as long to slow down as to speed up.",
            fixes=OF_BOTH,
        ),
        Closure(
            "slow to rise",
            ("rise",),
            "the driver follows a growing command late, a shrinking one at once",
            sentence="The drivers follow a growing command with a time constant of {rise}, a shrinking one at once.",
        ),
        Closure(
            "slow to fall",
            ("fall",),
            "the driver follows a shrinking command late, a growing one at once",
            sentence="The drivers follow a shrinking command with a time constant of {fall}, a growing one at once.",
        ),
        Closure(
            "slow both ways",
            ("rise", "fall"),
            "the driver's set points pass a filter",
            sentence="The drivers follow a growing command with a time constant of {rise}, a shrinking one of {fall}.",
        ),
        Closure(
            "each its filter",
            ("lag_left", "lag_right"),
            "set points of each side pass a filter of its own",
            sentence="The left driver follows its command within {lag_left}, the right one within {lag_right}.",
            fixes=OF_BOTH,
        ),
        Closure(
            "limited up",
            ("ramp_up",),
            "the driver's output grows by so much in a second at most",
            sentence="The drivers take {ramp_up} to let their output grow; it falls at once.",
        ),
        Closure(
            "limited down",
            ("ramp_down",),
            "the driver's output falls by so much in a second at most",
            sentence="The drivers take {ramp_down} to let their output fall; it grows at once.",
        ),
        Closure(
            "limited both ways",
            ("ramp_up", "ramp_down"),
            "as an acceleration limit and a deceleration limit do",
            sentence="The drivers take {ramp_up} to let their output grow and {ramp_down} to let it fall.",
        ),
    ),
    memory=2,
    order=60,
    dissipative=True,
)
