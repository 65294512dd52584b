"""A slot: one number that a fit may move; and what stands in the slots of a fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fsm_calib.types import FloatArray

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


def slot_numbers(values: FloatArray, slots: Sequence[Slot]) -> FloatArray:
    """Return what stands in the slots of `values` (R, p), shape (m,)."""
    return np.array([values[max(slot.run, 0), slot.place] for slot in slots])


def slot_bounds(slots: Sequence[Slot]) -> FloatArray:
    """Return the lowest and the highest numbers that slots may have, shape (2, m)."""
    return np.array([(slot.low, slot.high) for slot in slots]).reshape(-1, 2).T


def with_slots(values: FloatArray, slots: Sequence[Slot], numbers: FloatArray) -> FloatArray:
    """Return a copy of `values` (R, p) with `numbers` (m,) in the slots."""
    changed = values.copy()
    for slot, number in zip(slots, numbers, strict=True):
        changed[slice(None) if slot.run == ALL_RUNS else slot.run, slot.place] = number
    return changed
