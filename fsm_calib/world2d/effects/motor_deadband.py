r"""The motor does not answer small commands, or the driver over-compensates for that.

    u_effective = sgn(u) max(|u| - d, 0)          d >= 0 (dead zone)
    u_effective = sgn(u) (|u| - d)                d < 0 (over-compensated), for |u| > 0.01, else 0

u [1] command, d [1] offset. Duckietown's driver adds PWM 60 of 255 (0.235) to every command above 0.01 to
cancel the motor's own dead zone; what is left over has either sign. Sources: dagu_wheels_driver.py
(dt-duckiebot-interface); Tao & Kokotovic, Adaptive Control of Systems with Actuator and Sensor
Nonlinearities, 1996, chapter 2.
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.effects.effect import Effect, Parameter

RELEASE = 0.01
"""Command below which the driver releases the motor [1] (dagu_wheels_driver.py)."""


@njit(error_model="numpy")
def offset(P, o, u, side):
    """Return the command without the offset."""
    size = abs(u)
    if P[o] < 0.0 and size <= RELEASE:
        return 0.0
    return math.copysign(max(size - P[o], 0.0), u)


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
    order=30,
    dissipative=True,
)
