"""What of a fitted model holds on a recording that took no part in the fit: the robot's numbers, not the occasions'."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.slot import ALL_RUNS, Slot
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table


def on_new_recording(engine: Engine, fit: Fit) -> FloatArray:
    """Return the parameters (1, p) for a recording that took no part in the fit, `engine` of that one alone.

    Numbers of the robot are kept. Events did not happen. Phases are found on the new recording, from several starts.
    What the base robot has of each recording (the battery's charge) is as in the mean.
    """
    table = parameter_table()
    values = fit.values[:1].copy()
    own: list[Slot] = []
    for slot in fit.slots:
        if slot.run == ALL_RUNS:
            continue
        entry = table.entries[slot.place]
        if not table.owner[slot.place]:
            values[0, slot.place] = float(np.mean(fit.values[:, slot.place]))
        elif entry.strength:
            values[0, slot.place] = entry.null
        elif not _belongs_to_event(table.owner[slot.place]) and slot.run == 0:
            own.append(Slot(slot.place, slot.low, slot.high, slot.step, 0))
    for name in dict.fromkeys(table.owner[s.place] for s in fit.slots if s.run != ALL_RUNS):
        if name and _belongs_to_event(name):
            for place in table.of_effect(name):
                values[0, place] = table.entries[place].null
    return _fit_own(engine, fit, values, own) if own else values


def _belongs_to_event(effect: str) -> bool:
    return registry()[effect].scan == "time"


def _fit_own(engine: Engine, fit: Fit, values: FloatArray, own: Sequence[Slot]) -> FloatArray:
    whiteners = engine.whiteners(fit.noise)
    best, best_value = values, -np.inf
    for start in np.linspace(0.0, 2 * np.pi, 6, endpoint=False):
        tried = values.copy()
        for slot in own:
            tried[0, slot.place] = start
        value = engine.log_likelihood(whiteners, [engine.simulators[0].increments(tried)[0]])
        if value > best_value:
            best, best_value = tried, value
    return engine.fit(best, own, fit.noise, steps=6).values
