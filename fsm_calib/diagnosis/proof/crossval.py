"""Does the effect predict a recording that it was not fitted on? Leave-one-recording-out log predictive density.

Only for effects of the robot as a whole: a patch that one recording crossed and the other did not, or an event that
happened once, cannot be judged so (measured: right patches lose 300 to 1785 units).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.slot import ALL_RUNS, Slot
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

STEPS = 5


def is_global(hypothesis: Hypothesis) -> bool:
    """Return whether the effect acts in every recording and everywhere."""
    return hypothesis.run == ALL_RUNS and not registry()[hypothesis.effect].scan


def held_out_gains(engine: Engine, parent: Fit, fit: Fit) -> list[float]:
    """Return, for each recording, the log density that `fit`'s effects win over `parent` when fitted on the others.

    The base robot comes from the others, too; where the effects then win nothing, it is fitted again on the recording
    itself, on both sides, and the larger gain counts: a drive that cannot tell the axle from the wheels has no veto,
    nor has one so short that a base robot of its own explains it. Numbers that belong to one recording (a phase) are
    fitted on it. Empty with fewer than two recordings.
    """
    runs = len(engine.simulators)
    if runs < 2:
        return []
    return [_gain(engine, parent, fit, run) for run in range(runs)]


def _gain(engine: Engine, parent: Fit, fit: Fit, test: int) -> float:
    before, after = _learnt(engine, parent, test), _learnt(engine, fit, test)
    common = {slot.place for slot in parent.slots}
    gain = _density(engine, fit, after, test, set()) - _density(engine, parent, before, test, set())
    if gain > 0.0:
        return gain
    own = _density(engine, fit, after, test, common) - _density(engine, parent, before, test, common)
    return max(gain, own)


def _learnt(engine: Engine, fit: Fit, test: int) -> FloatArray:
    """Return the parameters (1, p) of recording `test` with what all recordings share fitted on the others."""
    others = [i for i in range(len(engine.simulators)) if i != test]
    train = Engine(tuple(engine.simulators[i] for i in others))
    fitted = train.fit(fit.values[others], _slots_for(fit.slots, others), fit.noise, steps=STEPS)
    values = fit.values[test : test + 1].copy()
    for slot in fit.slots:
        if slot.run == ALL_RUNS:
            values[0, slot.place] = fitted.values[0, slot.place]
    return values


def _density(engine: Engine, fit: Fit, values: FloatArray, test: int, free: set[int]) -> float:
    """Return the log density of recording `test` at `values` (1, p), fitting its own numbers and the places `free`."""
    alone = Engine((engine.simulators[test],))
    own = [s for s in _slots_for(fit.slots, [test]) if s.place in free or s.place in _own_places(fit, test)]
    return alone.fit(values, own, fit.noise, steps=STEPS if own else 0).log_likelihood


def _own_places(fit: Fit, run: int) -> set[int]:
    return {slot.place for slot in fit.slots if slot.run == run}


def _slots_for(slots: Sequence[Slot], runs: Sequence[int]) -> list[Slot]:
    """Return the slots that concern `runs`, renumbered."""
    kept = [s for s in slots if s.run == ALL_RUNS or s.run in runs]
    return [s if s.run == ALL_RUNS else replace(s, run=list(runs).index(s.run)) for s in kept]


def on_new_recording(engine: Engine, fit: Fit) -> FloatArray:
    """Return the parameters (1, p) for a recording that took no part in the fit, `engine` of that one alone.

    Numbers of the robot are kept. Events did not happen. Phases are found on the new recording, from several starts.
    """
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
