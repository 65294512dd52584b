"""Effects that may happen several times in one recording: the further times have the same numbers, counted from two.

A push has ``start`` and ``impulse_x``, the second push of the same drive ``start_2`` and ``impulse_x_2``. (This module
declares no effect.)
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from fsm_calib.world2d.effects.parameter import Parameter

COUNTS = {2: "two", 3: "three", 4: "four", 5: "five", 6: "six", 7: "seven", 8: "eight"}


def numbered(name: str, time: int) -> str:
    """Return the name that a number of the first time has at a later one."""
    return name if time == 1 else f"{name}_{time}"


def further(parameters: Iterable[Parameter], times: int) -> Iterator[Parameter]:
    """Yield the numbers of the second to the last of `times`; typically it happens once."""
    for time, p in ((time, p) for time in range(2, times + 1) for p in parameters):
        mirror = numbered(p.mirror, time) if p.mirror.startswith("swap:") else p.mirror
        name, symbol = numbered(p.name, time), f"{p.symbol}_{time}"
        yield replace(p, name=name, symbol=symbol, typical=p.null, mirror=mirror, step=p.difference_step)


def is_later(name: str) -> bool:
    """Return whether a number is one of a later time."""
    return name.rpartition("_")[2].isdigit()


def length_of(start: str) -> str:
    """Return the name of how long it lasted, by the name of when it began."""
    return start.replace("start", "duration")


def starts_in(names: Iterable[str]) -> list[str]:
    """Return those of some names that say when something begins, the first time or a later one."""
    return [name for name in names if name == "start" or (name.startswith("start_") and is_later(name))]


def times_in(names: Iterable[str]) -> list[tuple[str, str]]:
    """Return the names of begin and length of each time that some names tell of; of the first where they tell none."""
    return [(start, length_of(start)) for start in starts_in(names) or ["start"]]
