r"""Speed is not proportional to command: the gain falls (or grows) with the command.

    u_effective = u (1 - gamma |u|)           |u| <= 1 / (2 gamma), constant beyond

u [1] command, gamma [1] curvature: at command u the motor lacks gamma |u| of what its gain at small commands
promises. Drivers that recirculate current and batteries with inner resistance bend the line down. Source:
Sedra & Smith, Microelectronic Circuits, 7th ed., section 12 (output stages); DB18 measurements scatter by 5
to 15 % (duckietown-world).
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.effects.effect import Effect, Parameter


@njit(error_model="numpy")
def bend(P, o, u, side):
    """Return the bent command."""
    size = abs(u)
    if P[o] > 0.0:
        size = min(size, 0.5 / P[o])
    return (1.0 - P[o] * size) * (size if u > 0.0 else -size)


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
    order=40,
)
