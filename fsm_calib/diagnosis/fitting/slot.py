"""A slot: one number that a fit may move."""

from __future__ import annotations

from dataclasses import dataclass

ALL_RUNS = -1


@dataclass(frozen=True, slots=True)
class Slot:
    """One number that a fit may move: a place in the parameter vector, for all recordings or for one.

    low, high : bounds; step : finite difference; centre, spread : normal prior (spread 0 = none). Units of the
    parameter.
    """

    place: int
    low: float
    high: float
    step: float
    run: int = ALL_RUNS
    centre: float = 0.0
    spread: float = 0.0
