"""A number of the base robot that is free where the recordings ask for it, and no single effect does its job."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from fsm_calib.diagnosis.candidates.ranked import STRONG, Ranked, evidence_of
from fsm_calib.diagnosis.candidates.rivals import Rivals
from fsm_calib.diagnosis.fitting.base import SPEED_NOISE
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.slot import Slot, with_slots
from fsm_calib.diagnosis.fitting.wald import wald
from fsm_calib.types import FloatArray
from fsm_calib.world2d.parameters import parameter_table

STEPS = 8
NEEDED = STRONG  # evidence; no part is accused by it
SURE = 3.0  # standard deviations from its usual value, from which on a number is told
KEPT = 0.5  # of its evidence beside a rival: a spot of grease leaves the grip a fifth, a mat that brakes leaves it all


def found_free(fit: Fit, name: str) -> list[tuple[Slot, float, float]]:
    """Return where a number is free in a fit, with its value and standard deviation; one entry or one a recording."""
    place = parameter_table().place(name)
    return [
        (slot, value, float(np.sqrt(max(variance, 0.0))))
        for slot, value, variance in fit.numbers()
        if slot.place == place
    ]


def with_free(
    engine: Engine, fit: Fit, slots: Sequence[Slot], starts: Sequence[float | tuple[float, ...]]
) -> Fit:
    """Return the fit with more numbers free, the best of several starts, and the noise of speeds fitted again.

    starts : one number for all slots, or one for each.
    """
    tried = []
    for start in starts:
        values = with_slots(fit.values, slots, np.broadcast_to(start, len(slots)))
        tried.append(engine.fit(values, (*fit.slots, *slots), fit.noise, steps=STEPS))
    best = engine.refit_noise(max(tried, key=lambda t: t.score), SPEED_NOISE, 3)
    return engine.fit(best.values, best.slots, best.noise, steps=STEPS)


def with_held(fit: Fit, name: str, value: float | FloatArray) -> Fit:
    """Return the numbers of a fit with one of them held at a value, of all recordings or one each; not fitted again."""
    place = parameter_table().place(name)
    values = fit.values.copy()
    values[:, place] = value
    return replace(fit, values=values, slots=tuple(s for s in fit.slots if s.place != place))


def unless_stood_in(
    engine: Engine,
    base: Fit,
    freed: Callable[[Fit], Fit],
    rivals: Rivals,
    instead: Callable[[Ranked], Fit | None] = lambda rival: None,
    asked_again: bool = False,
) -> Fit:
    """Return the base with a number free that has strong evidence, also beside the rival that explains more.

    freed : what sets it free on top of a fit; instead : a rival with the number free in place of one of its own,
    where it has one like it: of two that do as well, the robot's own is likelier than a part that came out of
    place; rivals : effects that are asked whether one does as well by itself. They are ranked as a catalogue is,
    none given up for the evidence of the number: so a dead zone that has ten times as much was lost to a charge,
    and a scrubbing tyre (463 for 109) whose starts, to first order, reach too little. asked_again : the number has
    its say beside the first effect, too; so a rival that explains more goes first, beside which it has other values.
    """
    free = freed(base)
    evidence = evidence_of_freed(engine, free, base)
    if evidence < NEEDED:
        return base
    ranking = rivals.ranked_on(engine, base)
    if not ranking or ranking[0].evidence <= evidence:
        return free
    if asked_again:
        return base
    rival = ranking[0].fit
    if evidence_of_freed(engine, freed(rival), rival) >= max(NEEDED, KEPT * evidence):
        return free
    other = instead(ranking[0])
    as_good = other is not None and evidence_of(other, base, engine.count) > ranking[0].evidence - NEEDED
    return free if as_good else base


def evidence_of_freed(engine: Engine, free: Fit, parent: Fit) -> float:
    """Return the evidence of what is free in a fit and not in its parent; none where it hardly leaves its null value.

    The noise is fitted again with it, and that alone may win hundreds of units where the parent's was another
    model's: on a real robot 279 for a number of -0.06 +- 0.06.
    """
    own = wald(free, set(free.slots) - set(parent.slots))
    return evidence_of(free, parent, engine.count) if own >= NEEDED else 0.0
