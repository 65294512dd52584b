"""How late a robot is by itself: less is no delay, or one that no recording tells from how the robot is built.

The base's tyres lag by 2 to 3 ms (assumed), its motors are of first order: a delay below `LEAST_DELAY` is none. Below
`BUILT` something else may be as late. A robot that is told speeds has a controller that samples them: one of 20 Hz
answers 25 ms late in the mean. A caster that skids drags the more the faster the robot speeds up: carts of another
engine are 14 to 18 ms late where commands are ramped, and not at all at steps or with their load over the axle. Beside
either a delay of that size is part of the model, and a name with even odds. A robot that is told duties and drags no
caster has neither.

Commands that act late and poses that are stamped early by nearly as much are one lateness that two names share between
them: where no wheels are measured only their sum shows, and a fit lets the two grow against each other.
"""

from __future__ import annotations

from collections.abc import Mapping

LEAST_DELAY = 0.004  # s
BUILT = 0.025  # s
BUILDERS = ("speed_controller.hold", "caster_drag.drag")
"""The numbers of a model that tell of a controller, its integral, and of a caster that skids."""
DELAYS = ("command_delay.delay", "observation_delay.delay")
"""The numbers of a model whose sum alone shows where no wheels are measured."""
CANCELLED = (
    0.5  # of the larger of two delays: an opposite one that takes so much of it back is no delay of its own
)


def may_be_built_so(numbers: Mapping[str, float]) -> bool:
    """Return whether how the robot is built may be as late as a delay and a filter [s], or whether two delays mostly
    cancel, for `Closure.has_twin`.
    """
    late = max(abs(numbers.get(name, 0.0)) for name in ("delay", "smoothing", "apart"))
    return cancel(numbers) or (late < BUILT and any(numbers[name] > 0.0 for name in BUILDERS))


def cancel(numbers: Mapping[str, float]) -> bool:
    """Return whether commands and poses are late by opposite amounts of like size."""
    small, large = sorted((numbers[name] for name in DELAYS), key=abs)
    return small * large < 0.0 and abs(small) >= CANCELLED * abs(large)
