"""Does the effect predict a recording that it was not fitted on? Leave-one-recording-out log predictive density.

Only for effects of the robot as a whole: a patch that one recording crossed and the other did not, or an event that
happened once, cannot be judged so (measured: right patches lose 300 to 1785 units).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fsm_calib.diagnosis.fit import ALL_RUNS, Engine, Fit, Slot
from fsm_calib.diagnosis.hypotheses import Hypothesis
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import registry

STEPS = 5
RESCUE_STEPS = 4


def is_global(hypothesis: Hypothesis) -> bool:
    """Return whether the effect acts in every recording and everywhere."""
    return hypothesis.run == ALL_RUNS and not registry()[hypothesis.effect].scan


def held_out_gains(engine: Engine, parent: Fit, fit: Fit) -> list[float]:
    """Return, for each recording, the log density that `fit`'s model wins over `parent`'s when fitted on the others.

    Empty with fewer than two recordings. Numbers that belong to one recording (a phase) are fitted on it alone.
    """
    runs = len(engine.simulators)
    if runs < 2:
        return []
    return [_density(engine, fit, test) - _density(engine, parent, test) for test in range(runs)]


def _density(engine: Engine, fit: Fit, test: int) -> float:
    """Return the log density of recording `test` under the model of `fit`, fitted on all others."""
    others = [i for i in range(len(engine.simulators)) if i != test]
    train = Engine(tuple(engine.simulators[i] for i in others))
    slots, _ = _slots_for(fit.slots, others)
    fitted = train.fit(fit.values[others], slots, fit.noise, steps=STEPS)
    values = fitted.values[:1].copy()
    _, own = _slots_for(fit.slots, [test])
    for slot in own:
        values[0, slot.place] = fit.values[test, slot.place]
    alone = Engine((engine.simulators[test],))
    if own:
        values = alone.fit(values, own, fit.noise, steps=RESCUE_STEPS).values
    simulated = alone.simulators[0].increments(values)
    return alone.log_likelihood(alone.whiteners(fit.noise), [simulated[0]])


def _slots_for(slots: Sequence[Slot], runs: Sequence[int]) -> tuple[list[Slot], list[Slot]]:
    """Return all slots that concern `runs`, renumbered, and those among them that belong to one recording."""
    kept = [s for s in slots if s.run == ALL_RUNS or s.run in runs]
    renumbered = [
        Slot(
            s.place,
            s.low,
            s.high,
            s.step,
            s.run if s.run == ALL_RUNS else list(runs).index(s.run),
            s.centre,
            s.spread,
        )
        for s in kept
    ]
    return renumbered, [s for s in renumbered if s.run != ALL_RUNS]


def on_new_recording(engine: Engine, fit: Fit) -> FloatArray:
    """Return the parameters (1, p) for a recording that took no part in the fit, `engine` of that one alone.

    Numbers of the robot are kept. Events did not happen. Phases are found on the new recording, from several starts.
    """
    from fsm_calib.world2d.parameters import parameter_table

    table = parameter_table()
    values = fit.values[:1].copy()
    own: list[Slot] = []
    for slot in fit.slots:
        if slot.run == ALL_RUNS:
            continue
        entry = table.entries[slot.place]
        if entry.strength:
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
