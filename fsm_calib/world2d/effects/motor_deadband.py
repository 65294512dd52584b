r"""The motor does not answer small commands, or the driver over-compensates for that.

    u_effective = sgn(u) max(|u| - d, 0)          d >= 0 (dead zone)
    u_effective = sgn(u) (|u| - d)                d < 0 (over-compensated), for |u| > 0.01, else 0
    u_effective = u g((|u| - threshold) / 0.01)   ignored below a threshold, g from 0 to 1 over (-1/2, 1/2)

u [1] command, d [1] offset of both wheels, or of the left and the right each (d_l, d_r come on top), threshold [1] that
of a driver, joystick or base controller that ignores what is smaller and takes the rest whole, or of each motor's own
driver (threshold_left, threshold_right come on top).
Duckietown's driver adds PWM 60 of 255 (0.235) to every command above 0.01 to cancel the motor's own dead zone;
what is left over has either sign. Sources: dagu_wheels_driver.py (dt-duckiebot-interface); Tao & Kokotovic,
Adaptive Control of Systems with Actuator and Sensor Nonlinearities, 1996, chapter 2.
"""

from __future__ import annotations

import math
from dataclasses import replace

from numba import njit

from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.effects.wheels import of_each_wheel

RELEASE = 0.01
"""Command below which the driver releases the motor [1] (dagu_wheels_driver.py)."""
EDGE = 0.01
"""Commands over which a threshold lets through [1]: an edge that a fit can feel."""


@njit(error_model="numpy")
def offset(P, o, u, side):
    """Return the command without the offset."""
    size, lost = abs(u), P[o] + P[o + 1 + side]
    threshold = P[o + 3] + P[o + 4 + side]
    if threshold > 0.0:
        u *= min(max((size - threshold) / EDGE + 0.5, 0.0), 1.0)
        size = abs(u)
    if lost < 0.0 and size <= RELEASE:
        return 0.0
    return math.copysign(max(size - lost, 0.0), u)


THRESHOLD = Parameter(
    "threshold",
    "u_0",
    "1",
    0.0,
    0.0,
    0.6,
    0.0,
    "dead zones of joysticks and base controllers: 0.02 to 0.15",
    starts=(0.03, 0.06, 0.1, 0.15, 0.25),
    step=4e-3,
    edge=EDGE,
)
"""Of a driver that ignores smaller commands, the same for both motors."""

EFFECT = Effect(
    name="motor_deadband",
    family="command map",
    summary="small commands do nothing, or too much (over-compensation)",
    equation="u_eff = sgn(u) max(|u| - d, 0)",
    parameters=(
        Parameter(
            "offset",
            "d",
            "1",
            0.0,
            -2.0,
            0.4,
            0.05,
            "driver: 60/255 added, residual either sign; loaded DB18: -0.9 (docs/robots/duckiebot-watchtower.md)",
            starts=(0.04, -0.04, -0.4),
        ),
        *of_each_wheel(
            Parameter(
                "offset",
                "d",
                "1",
                0.0,
                -0.6,
                0.4,
                0.0,
                "gears of one motor run dry, one driver is trimmed",
                starts=(0.04, -0.04),
            )
        ),
        THRESHOLD,
        *of_each_wheel(
            replace(
                THRESHOLD,
                source="speed controllers of radio control have a neutral zone each: 0.03 to 0.1",
                starts=(0.05, 0.1, 0.15, 0.2),
                rugged=True,
            )
        ),
    ),
    hooks={"shape": offset},
    channels=("forward", "turn"),
    regimes=("slow", "small_command"),
    separates="the same piece of every command is lost; a gain curve loses more at high commands",
    rivals=("motor_gain_curve", "coulomb_friction", "caster_drag", "command_saturation"),
    manoeuvre="straights and spins at five speeds down to commands of 0.05",
    sentence="The motors lose {offset} of every command (negative: the driver adds too much).",
    source="Duckietown dagu_wheels_driver.py; Tao & Kokotovic 1996",
    input="command",
    closures=(
        Closure("both alike", ("offset",), "the same piece of both commands"),
        Closure(
            "left wheel",
            ("offset_left",),
            "of the left wheel alone",
            sentence="The left motor loses {offset_left} of every command (negative: the driver adds too much).",
        ),
        Closure(
            "right wheel",
            ("offset_right",),
            "of the right wheel alone",
            sentence="The right motor loses {offset_right} of every command (negative: the driver adds too much).",
        ),
        Closure(
            "each its own",
            ("offset_left", "offset_right"),
            "another piece of each command",
            sentence="The motors lose {offset_left} (left) and {offset_right} (right) of every command.",
        ),
        Closure(
            "ignored when small",
            ("threshold",),
            "small commands alone are lost, larger ones act whole",
            sentence="Commands below {threshold} do nothing, larger ones act whole.",
        ),
        *(
            Closure(
                f"{side} ignored when small",
                (f"threshold_{side}",),
                f"small commands of the {side} motor alone are lost",
                sentence=f"Commands of the {side} motor below {{threshold_{side}}} do nothing, larger ones act whole.",
            )
            for side in ("left", "right")
        ),
        Closure(
            "each ignored when small",
            ("threshold_left", "threshold_right"),
            "small commands of each motor are lost, below a threshold of its own",
            sentence="Commands below {threshold_left} (left), {threshold_right} (right) do nothing, larger ones act "
            "whole.",
            extends=("left ignored when small", "right ignored when small"),
        ),
    ),
    order=30,
    dissipative=True,
)
