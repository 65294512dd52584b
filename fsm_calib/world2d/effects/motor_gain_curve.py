r"""Speed is not proportional to command: the gain falls (or grows) with the command.

    u_effective = u (1 - gamma |u|)           |u| <= 1 / (2 gamma), constant beyond
    u_effective = u |u|^p                     as a power law
    u_effective = u + s sin(2 pi u) / (2 pi)  S-shaped

u [1] command, gamma [1] curvature, of both wheels or (gamma_l, gamma_r) of one, p [1] exponent beyond one, s [1]
swing: the gain is 1 + s at both ends and 1 - s in the middle. At command u the motor lacks gamma |u| of what its gain
at small commands promises. Drivers that recirculate current and batteries with inner resistance bend the line down;
crossover and compression of output stages make an S, of which s is the first harmonic. Source: Sedra & Smith,
Microelectronic Circuits, 7th ed., section 12 (output stages); DB18 measurements scatter by 5 to 15 %
(duckietown-world).
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.effects.wheels import of_each_wheel


@njit(error_model="numpy")
def bend(P, o, u, side):
    """Return the bent command."""
    size, gamma = abs(u), P[o] + P[o + 1 + side]
    if gamma > 0.0:
        size = min(size, 0.5 / gamma)
    size *= 1.0 - gamma * size
    if P[o + 3] != 0.0 and size > 0.0:
        size = math.pow(size, 1.0 + P[o + 3])
    if P[o + 4] != 0.0 and size < 1.0:
        size += P[o + 4] * math.sin(2.0 * math.pi * size) / (2.0 * math.pi)
    return size if u > 0.0 else -size


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
    ),
    hooks={"shape": bend},
    channels=("forward", "turn"),
    regimes=("large_command", "small_command"),
    separates="bends over the whole range, where a dead band shifts and a limit cuts",
    rivals=("motor_deadband", "command_saturation", "coulomb_friction"),
    manoeuvre="straights at five speeds from 0.05 to full command",
    sentence="The motors' gain changes by {curvature} of itself over the range of commands.",
    source="torque-speed line with a non-ideal driver",
    input="command",
    closures=(
        Closure("both alike", ("curvature",), "the same bend of both motors"),
        Closure(
            "left wheel",
            ("curvature_left",),
            "of the left wheel alone",
            sentence="The left motor's gain changes by {curvature_left} of itself over the range of commands.",
        ),
        Closure(
            "right wheel",
            ("curvature_right",),
            "of the right wheel alone",
            sentence="The right motor's gain changes by {curvature_right} of itself over the range of commands.",
        ),
        Closure(
            "each its own",
            ("curvature_left", "curvature_right"),
            "another bend of each motor",
            sentence="The motors' gains change by {curvature_left} (left) and {curvature_right} (right) of themselves.",
        ),
        Closure(
            "power law",
            ("power",),
            "speed grows as a power of the command",
            sentence="Speed grows with the command to the power of 1 + {power}.",
            source="Franklin, Powell & Emami-Naeini, Feedback Control, section 9.2 (power-law actuators)",
        ),
        Closure(
            "S-shaped",
            ("swing",),
            "more at both ends than in the middle, or less",
            sentence="The gain is {swing} of itself higher at small and full commands, and as much lower between.",
        ),
    ),
    order=40,
)
