r"""Is it one law in all drives? How much of an effect's gain is lost where its numbers come from the other drives.

    moved = 1 - sum_r [log L_r(e from the others, base from r) - log L_r(base from r)] / sum_r [the same, e from all]

log L_r [1] the log-likelihood of recording r; e the numbers of the effect, base those of everything else, re-fitted on
r in both terms, so that drives which tell the axle or the tyres apart by their own only have no say. Of an effect with
a place or with choices of each recording (a phase) those stay as all drives have them: only its strengths are learnt.
Right names, also by another law than ours, lose next to nothing (-0.03 to 0.15, median 0.02); physics that merely
resembles a name asks for other numbers in each drive (0.27 to 5.9; 45 and 8 robots whose laws others wrote).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.slot import ALL_RUNS, Slot
from fsm_calib.diagnosis.fitting.values import switched_off
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

STEPS = 12  # Gauss-Newton steps at most from the fit of all recordings
LEAST_SHARE = 0.1  # of the gain that the other drives must carry, to have learnt anything


@dataclass(frozen=True, slots=True)
class OneLaw:
    """moved : share of the gain that is lost, nan where it cannot be asked; gains : of each recording, (R,)."""

    moved: float
    gains: tuple[float, ...]


def one_law(engine: Engine, parent: Fit, fit: Fit, effect: str) -> OneLaw:
    """Return how much of what `effect` adds to `parent` in `fit` is lost between the recordings.

    nan for one recording, for an event, which is an occasion and no law (whether it came alike in all of them is asked
    where it is found), and for a place that one recording alone has crossed.
    """
    runs = range(len(engine.simulators))
    learnt = [s for s in fit.slots if _is_learnt(s, effect)]
    if len(runs) < 2 or not learnt or registry()[effect].scan == "time":
        return OneLaw(np.nan, ())
    bare = [_without(engine, parent, fit, run, effect) for run in runs]
    kept = [_score(engine, parent, fit, run, fit.values[run : run + 1]) - bare[run] for run in runs]
    total = sum(kept)
    if total <= 0.0 or total - max(kept) < LEAST_SHARE * total:
        return OneLaw(np.nan, tuple(kept))
    others = (_from_others(engine, fit, learnt, run) for run in runs)
    moved = [_score(engine, parent, fit, run, v) - bare[run] for run, v in zip(runs, others, strict=True)]
    return OneLaw(1.0 - sum(moved) / total, tuple(moved))


def _is_learnt(slot: Slot, effect: str) -> bool:
    """Return whether a slot is a strength of the effect that all recordings share."""
    table = parameter_table()
    return table.owner[slot.place] == effect and slot.run == ALL_RUNS and table.entries[slot.place].strength


def _from_others(engine: Engine, fit: Fit, learnt: Sequence[Slot], run: int) -> FloatArray:
    """Return the parameters (1, p) of a recording with the effect's strengths as the other recordings have them."""
    others = [r for r in range(len(engine.simulators)) if r != run]
    train = Engine(tuple(engine.simulators[r] for r in others))
    table, owner = parameter_table(), parameter_table().owner[learnt[0].place]
    free = [s for s in fit.slots if table.owner[s.place] != owner or s in learnt]
    fitted = train.fit(fit.values[others], _renumbered(free, others), fit.noise, steps=STEPS)
    values = fit.values[run : run + 1].copy()
    for slot in learnt:
        values[0, slot.place] = fitted.values[0, slot.place]
    return values


def _without(engine: Engine, parent: Fit, fit: Fit, run: int, effect: str) -> float:
    """Return the best log density of one recording without the effect.

    A base robot that stands in for a large effect has several optima, so it starts where all recordings have it
    without the effect and where they have it beside the effect: from one of them alone the last bits of a sum decide
    in which optimum it ends (1042, 1063 or, from the other, 1084 on one drive of a real Duckiebot).
    """
    starts = (parent.values, switched_off(fit.values, [effect]))
    return max(_score(engine, parent, fit, run, values[run : run + 1]) for values in starts)


def _score(engine: Engine, parent: Fit, fit: Fit, run: int, values: FloatArray) -> float:
    """Return the log density of one recording from `values` (1, p), what `parent` frees re-fitted on it alone."""
    rest = _renumbered(parent.slots, [run])
    return Engine((engine.simulators[run],)).fit(values, rest, fit.noise, steps=STEPS).score


def _renumbered(slots: Sequence[Slot], runs: Sequence[int]) -> list[Slot]:
    """Return the slots that concern `runs`, with their numbers among these."""
    kept = [s for s in slots if s.run == ALL_RUNS or s.run in runs]
    return [s if s.run == ALL_RUNS else replace(s, run=list(runs).index(s.run)) for s in kept]
