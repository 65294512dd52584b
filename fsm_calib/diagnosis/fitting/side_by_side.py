"""Fits that do not ask each other, worked out side by side by as many processes as an engine may use."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeVar

from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.workers import each

Thing = TypeVar("Thing")
Result = TypeVar("Result")


def side_by_side(
    engine: Engine, work: Callable[[Thing], Result], things: Iterable[Thing], *fits: Fit
) -> list[Result]:
    """Return what comes of every thing, in order (`workers.each`).

    fits : those whose large parts the results hold, too; the results hold them themselves, not copies.
    """
    return each(work, things, engine.processes, [part for fit in fits for part in fit.parts])
