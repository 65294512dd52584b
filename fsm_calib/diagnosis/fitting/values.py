"""Parameter values with names set, in all recordings or one, and effects switched off."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from fsm_calib.diagnosis.fitting.slot import ALL_RUNS
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table


def with_values(values: FloatArray, changes: Mapping[str, float], run: int = ALL_RUNS) -> FloatArray:
    """Return a copy of `values` (R, p) with full names set, in all recordings or one."""
    table, changed = parameter_table(), values.copy()
    for name, value in changes.items():
        changed[slice(None) if run == ALL_RUNS else run, table.place(name)] = value
    return changed


def switched_off(values: FloatArray, effects: Iterable[str]) -> FloatArray:
    """Return a copy of `values` (R, p) with the strengths of `effects` at their null values."""
    strengths = [(registry()[name], p) for name in effects for p in registry()[name].strengths]
    return with_values(values, {f"{e.name}.{p}": e.parameter(p).null for e, p in strengths})


def taken_over(values: FloatArray, effect: str, source: FloatArray) -> FloatArray:
    """Return a copy of `values` (R, p) with an effect's numbers as `source` (R, p) has them."""
    changed, own = values.copy(), list(parameter_table().of_effect(effect))
    changed[:, own] = source[:, own]
    return changed
