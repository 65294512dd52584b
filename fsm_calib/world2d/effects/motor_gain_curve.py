r"""Speed is not proportional to command: the gain falls (or grows) with the command.

    u_effective = u (1 - gamma |u|)           |u| <= 1 / (2 gamma), constant beyond
    u_effective = u |u|^p                     as a power law
    u_effective = u + s sin(2 pi u) / (2 pi)  S-shaped
    u_effective = t(u)                        read off a table: straight between 0, the entries at 1/4, 1/2, 3/4, and 1
    T -> T / b,    D -> D b,    b = 1 - coasting (1 - |u|)       a bridge that coasts

u [1] command, gamma [1] curvature, of both wheels or (gamma_l, gamma_r) of one, p [1] exponent beyond one, of both
wheels or (p_l, p_r) of one, s [1] swing: the gain is 1 + s at both ends and 1 - s in the middle. At command u the motor
lacks gamma |u| of what its gain at small commands promises. Drivers that recirculate current and batteries with inner
resistance bend the line down; crossover and compression of output stages make an S, of which s is the first harmonic.
coasting [1] is the share of a pulse's off time in which the bridge is open: the motor's own voltage brakes it only
while the bridge conducts, a share b [1] of the time, so that the no-load speed T [m/s] is that of a larger command and
the slope D [N s/m] of the torque is small: fast at small commands, but weak, and it rolls out where it is told to stop.
Source: Sedra & Smith, Microelectronic Circuits, 7th ed., section 12 (output stages); DB18 measurements scatter by 5 to
15 % (duckietown-world); Texas Instruments, DRV8833 data sheet, section 7.3 (fast and slow decay); lookup tables:
Press et al., Numerical Recipes, 3rd ed. 2007, chapter 3.
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.effects.wheels import is_the_others, of_each_wheel, of_one_driver_or_both
from fsm_calib.world2d.slots import COMMAND, DRIVE, TARGET

TABLE = "tables of other motors: a tenth off"
BY_NO_TABLE = {"table_side": 0.0}
"""Where no entry is wrong the side is told by nothing."""
LEAST_SHARE = 0.05
"""Least share of the time [1] in which a bridge conducts: no motor is without any braking (assumed)."""


@njit(error_model="numpy")
def bend(P, o, u, side):
    """Return the bent command."""
    size, gamma = abs(u), P[o] + P[o + 1 + side]
    if gamma > 0.0:
        size = min(size, 0.5 / gamma)
    size *= 1.0 - gamma * size
    power = P[o + 3] + P[o + 6 + side]
    if power != 0.0 and size > 0.0:
        size = math.pow(size, 1.0 + power)
    if P[o + 4] != 0.0 and size < 1.0:
        size += P[o + 4] * math.sin(2.0 * math.pi * size) / (2.0 * math.pi)
    if not is_the_others(P[o + 11], side):
        size = read_off(P, o + 8, size)
    return size if u > 0.0 else -size


@njit(error_model="numpy")
def read_off(P, o, size):
    """Return a command's size by a table whose entries at 1/4, 1/2 and 3/4 are wrong by P[o] to P[o + 2]."""
    k = min(int(4.0 * size), 3)
    low = 0.25 * k * (1.0 + P[o + k - 1]) if k > 0 else 0.0
    high = 0.25 * (k + 1) * (1.0 + P[o + k]) if k < 3 else 1.0
    return low + (4.0 * size - k) * (high - low)


@njit(error_model="numpy")
def coast(P, o, S, m, W):
    """Let each motor brake itself only while its bridge conducts."""
    if P[o + 5] <= 0.0:
        return
    for side in range(2):
        share = max(1.0 - P[o + 5] * (1.0 - min(abs(W[COMMAND + side]), 1.0)), LEAST_SHARE)
        W[TARGET + side] /= share
        W[DRIVE + side] *= share


EFFECT = Effect(
    name="motor_gain_curve",
    family="command map",
    summary="gain falls or grows with the command",
    equation="u_eff = u (1 - gamma |u|)",
    parameters=(
        Parameter(
            "curvature",
            "gamma",
            "1",
            0.0,
            -1.5,
            1.5,
            0.2,
            "0.05 to 0.15 of gain lost at full command",
            starts=(0.2, -0.2),
        ),
        *of_each_wheel(
            Parameter(
                "curvature",
                "gamma",
                "1",
                0.0,
                -1.5,
                1.5,
                0.0,
                "one driver channel, one worn motor",
                starts=(0.2, -0.2),
            )
        ),
        Parameter(
            "power", "p", "1", 0.0, -0.6, 1.5, 0.0, "drivers with exponential maps", starts=(0.2, -0.15)
        ),
        Parameter(
            "swing", "s", "1", 0.0, -0.95, 0.95, 0.0, "weak or strong in the middle", starts=(0.15, -0.15)
        ),
        Parameter(
            "coasting", "c", "1", 0.0, 0.0, 0.95, 0.0, "0 in slow decay, towards 1 in fast", starts=(0.1, 0.5)
        ),
        *of_each_wheel(
            Parameter(
                "power", "p", "1", 0.0, -0.6, 1.5, 0.0, "one channel of the driver", starts=(0.2, -0.15)
            )
        ),
        Parameter("table_quarter", "e_1", "1", 0.0, -0.6, 0.6, 0.0, TABLE),
        Parameter("table_half", "e_2", "1", 0.0, -0.6, 0.6, 0.0, TABLE, starts=(0.1, -0.1)),
        Parameter("table_three_quarters", "e_3", "1", 0.0, -0.3, 0.3, 0.0, TABLE),
        of_one_driver_or_both("table_side", "d"),
    ),
    hooks={"shape": bend, "step": coast},
    channels=("forward", "turn"),
    regimes=("large_command", "small_command"),
    separates="bends over the whole range, where a dead band shifts and a limit cuts",
    rivals=("motor_deadband", "command_saturation", "coulomb_friction"),
    manoeuvre="straights at five speeds from 0.05 to full command",
    sentence="The motors' gain changes by {curvature} of itself over the range of commands.",
    source="torque-speed line with a non-ideal driver",
    input="command",
    closures=(
        Closure("both alike", ("curvature",), "the same bend of both motors", fixes=BY_NO_TABLE),
        Closure(
            "left wheel",
            ("curvature_left",),
            "of the left wheel alone",
            sentence="The left motor's gain changes by {curvature_left} of itself over the range of commands.",
            fixes=BY_NO_TABLE,
        ),
        Closure(
            "right wheel",
            ("curvature_right",),
            "of the right wheel alone",
            sentence="The right motor's gain changes by {curvature_right} of itself over the range of commands.",
            fixes=BY_NO_TABLE,
        ),
        Closure(
            "each its own",
            ("curvature_left", "curvature_right"),
            "another bend of each motor",
            sentence="The motors' gains change by {curvature_left} (left) and {curvature_right} (right) of themselves.",
            fixes=BY_NO_TABLE,
        ),
        Closure(
            "power law",
            ("power",),
            "speed grows as a power of the command",
            sentence="Speed grows with the command to the power of 1 + {power}.",
            source="Franklin, Powell & Emami-Naeini, Feedback Control, section 9.2 (power-law actuators)",
            fixes=BY_NO_TABLE,
        ),
        Closure(
            "left power law",
            ("power_left",),
            "the left wheel's speed grows as a power of its command",
            sentence="The left wheel's speed grows with its command to the power of 1 + {power_left}.",
            fixes=BY_NO_TABLE,
        ),
        Closure(
            "right power law",
            ("power_right",),
            "the right wheel's speed grows as a power of its command",
            sentence="The right wheel's speed grows with its command to the power of 1 + {power_right}.",
            fixes=BY_NO_TABLE,
        ),
        Closure(
            "S-shaped",
            ("swing",),
            "more at both ends than in the middle, or less",
            sentence="The gain is {swing} of itself higher at small and full commands, and as much lower between.",
            fixes=BY_NO_TABLE,
        ),
        Closure(
            "coasting",
            ("coasting",),
            "the bridge is open in a part of each pulse, so that the motor does not brake itself",
            sentence="The motors coast in {coasting} of their pulses' off time: fast at small commands, and weak.",
            source="Texas Instruments, DRV8833 data sheet, section 7.3",
            fixes=BY_NO_TABLE,
        ),
        Closure(
            "table",
            ("table_quarter", "table_half", "table_three_quarters"),
            "read off a table of few entries, wrong each by its own share",
            sentence="The motors' table is off by {table_quarter}, {table_half}, {table_three_quarters} at a quarter, "
            "a half and three quarters of full command.",
            source="Press et al., Numerical Recipes, 3rd ed. 2007, chapter 3",
        ),
    ),
    order=40,
)
