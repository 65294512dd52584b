"""Duckietown's whole PWM numbers, and commands spread over them so that their mean is what was asked for.

Its driver makes ``floor(|u| 195 + 60)`` of a command u, at most 255, and zero below 0.01 (dt-duckiebot-interface,
``wheels_driver``): one step is 2.2 % of a command of 0.23, four times what a straight drive needs.
"""

from __future__ import annotations

import math

STEPS = 195
"""PWM numbers from the least that turns a wheel to the most."""
OFFSET, LARGEST = 60, 255
"""The least PWM number that turns a wheel, and the largest."""
LEAST = 0.01
"""Commands up to this release the wheel [1]."""


def floored(command: float, least: float = LEAST) -> float:
    """Return what the driver makes of a command [1]; up to `least` it releases the wheel."""
    if abs(command) <= least:
        return 0.0
    return math.copysign(min(math.floor(abs(command) * STEPS + 1e-9), STEPS) / STEPS, command)


def command_of(level: float) -> float:
    """Return the command, the middle of a PWM step, of an acknowledged level: PWM / 255 with a sign [1] (ente)."""
    number = round(abs(level) * LARGEST)
    if number == 0:
        return 0.0
    return math.copysign(min((number - OFFSET + 0.5) / STEPS, 1.0), level)


def level_of(command: float) -> float:
    """Return the level that the driver acknowledges for a command that it has floored [1]; see `command_of`."""
    if command == 0.0:
        return 0.0
    return math.copysign((abs(command) * STEPS + OFFSET) / LARGEST, command)


class Dither:
    """One wheel's sigma-delta modulator: rounds, and carries the rest to the next command."""

    def __init__(self) -> None:
        self._rest = 0.0

    def __call__(self, command: float) -> float:
        """Return the command to send [1]: the middle of a PWM step, so that the floor hits it."""
        if abs(command) <= LEAST:
            self._rest = 0.0
            return 0.0
        wanted = abs(command) * STEPS + self._rest
        number = min(max(round(wanted), 1), STEPS)
        self._rest = min(max(wanted - number, -1.0), 1.0)
        return math.copysign(min((number + 0.5) / STEPS, 1.0), command)
