"""How late a robot is by itself: less is no delay, or one that no recording tells from how the robot is built.

The base's tyres lag by 2 to 3 ms (assumed), its motors are of first order: a delay below `LEAST_DELAY` is none. Below
`BUILT` something else may be as late. A robot that is told speeds has a controller that samples them: one of 20 Hz
answers 25 ms late in the mean. A caster that skids drags the more the faster the robot speeds up: carts of another
engine are 14 to 18 ms late where commands are ramped, and not at all at steps or with their load over the axle. Beside
either a delay of that size is part of the model, and a name with even odds. A robot that is told duties and drags no
caster has neither.
"""

from __future__ import annotations

from collections.abc import Mapping

LEAST_DELAY = 0.004  # s
BUILT = 0.025  # s
BUILDERS = ("speed_controller.hold", "caster_drag.drag")
"""The numbers of a model that tell of a controller, its integral, and of a caster that skids."""


def may_be_built_so(numbers: Mapping[str, float]) -> bool:
    """Return whether how the robot is built may be as late as a delay and a filter [s], for `Closure.has_twin`."""
    late = max(abs(numbers.get(name, 0.0)) for name in ("delay", "smoothing"))
    return late < BUILT and any(numbers[name] > 0.0 for name in BUILDERS)
