"""Numbers of a loop that holds a wheel's speed, shared by effects (this module declares no effect)."""

from __future__ import annotations

from fsm_calib.world2d.effects.parameter import Parameter

NEVER = 2.0
"""Limit [1], as a share of full command, that no command reaches."""
AMPLE = 1.05
"""Where a supply ends [1] that reaches full command under what friction takes; below it is short of voltage."""


def gain_of_the_loop(name: str, symbol: str) -> Parameter:
    """Return the loop's proportional gain [1] over the slope of the motor's torque-speed line.

    Without a gain no more is asked for than the set point: a limit of commands would be an end of the supply, too.
    """
    return Parameter(
        name,
        symbol,
        "1",
        2.0,
        0.3,
        30.0,
        2.0,
        "wheel speed loops: 0.5 to 10",
        strength=False,
        starts=(1.0, 4.0),
    )
