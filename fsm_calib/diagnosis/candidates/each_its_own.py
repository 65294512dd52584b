"""An event that came alike in every recording, with numbers of its own in each: two pushes are seldom quite alike."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis, slots_of
from fsm_calib.diagnosis.candidates.pushed import IMPULSES
from fsm_calib.diagnosis.candidates.ranked import STRONG, Ranked, evidence_of
from fsm_calib.diagnosis.candidates.scan_pushes import turns
from fsm_calib.diagnosis.fitting.fit import Engine
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.replay.simulator import scale_of
from fsm_calib.diagnosis.replay.situation import situations_of
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect, registry
from fsm_calib.world2d.parameters import parameter_table

STEPS = 6


def each_its_own(engine: Engine, ranked: Ranked) -> Ranked | None:
    """Return the event with the numbers that its recordings share free in each; None where they tell nothing more.

    An effect that is no such event has none.
    """
    effect, event = registry()[ranked.name], ranked.hypothesis
    shared = effect.closure(event.closure) if event.closure else None
    if shared is None or not shared.alike:
        return None
    plain = next(c for c in effect.competing if c.frees == shared.frees)
    form = Hypothesis(effect.name, plain.frees, 0, event.chance, plain.name)
    runs, scale = range(len(engine.simulators)), scale_of(engine.simulators[0])
    owner, fit = parameter_table().owner, ranked.fit
    others = tuple(slot for slot in fit.slots if owner[slot.place] != effect.name)
    own = tuple(slot for run in runs for slot in slots_of(replace(form, run=run), len(runs), scale))
    free = engine.fit(_along_the_room(engine, effect, fit.values), (*others, *own), fit.noise, steps=STEPS)
    more = evidence_of(free, fit, engine.count)
    if more <= STRONG:
        return None
    return Ranked(form, free, ranked.evidence + more, ranked.gain + free.score - fit.score)


def _along_the_room(engine: Engine, effect: Effect, values: FloatArray) -> FloatArray:
    """Return parameters (R, p) with a push along the robot told along the room, where the robot points as it comes."""
    table, along = parameter_table(), f"{effect.name}.along"
    if along not in table.index or not values[0, table.place(along)] > 0.0:
        return values
    changed, start = with_values(values, {along: 0.0}), table.place(f"{effect.name}.start")
    impulse = [table.place(f"{effect.name}.{name}") for name in IMPULSES]
    for run, s in enumerate(situations_of(engine.simulators, values)):
        heading = np.interp(values[run, [start]], s.time, s.heading)
        changed[run, impulse] = turns(heading)[0] @ values[run, impulse]
    return changed
