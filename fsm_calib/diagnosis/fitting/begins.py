"""When an event of a fit begins, each time that it happened in a recording."""

from __future__ import annotations

from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.effects.numbered import starts_in
from fsm_calib.world2d.parameters import parameter_table


def begins_of(fit: Fit, name: str, run: int) -> list[float]:
    """Return each begin [s] of an effect that is free in a recording."""
    table = parameter_table()
    free = {slot.place for slot in fit.slots if slot.run == run}
    places = [table.place(f"{name}.{n}") for n in starts_in(p.name for p in registry()[name].parameters)]
    return [float(fit.values[run, place]) for place in places if place in free]
