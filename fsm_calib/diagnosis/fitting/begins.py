"""When an event of a fit begins, each time that it happened in a recording."""

from __future__ import annotations

from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.effects.numbered import starts_in
from fsm_calib.world2d.parameters import parameter_table


def begins_of(fit: Fit, name: str, run: int) -> list[tuple[str, float]]:
    """Return the name and the value [s] of each begin of an effect that is free in a recording."""
    table = parameter_table()
    free = {slot.place for slot in fit.slots if slot.run == run}
    places = {n: table.place(f"{name}.{n}") for n in starts_in(p.name for p in registry()[name].parameters)}
    return [(n, float(fit.values[run, place])) for n, place in places.items() if place in free]
