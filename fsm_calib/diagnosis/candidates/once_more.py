"""An event of a model once more, in a recording that has it already: the scan's next moment, with numbers of its own.

A scan offers several times at once only where they stand out together. A plug that opens twice, once while the robot
rests nearly, does not; each is told by itself when the other is known.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from fsm_calib.diagnosis.candidates.candidate import Candidate
from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis
from fsm_calib.diagnosis.candidates.scanned import Plans
from fsm_calib.diagnosis.candidates.starts import Start
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Closure, Effect
from fsm_calib.world2d.effects.numbered import length_of, numbered, starts_in
from fsm_calib.world2d.parameters import parameter_table

SHORTEST = 0.1  # of the scan's span: a moment in which all is lost is shorter than one in which a part is


def once_more(
    effect: Effect, kind: set[str], at: tuple[int, int], candidates: Iterable[Candidate], values: FloatArray
) -> Plans:
    """Return forms of one time more, with where each starts; none where the catalogue ends before.

    kind : closures of the event that the model has; at : the recording, and how many times it is known to have come
    there; candidates : of a scan on top of `values` (R, p). What all times share (a motor's loss) stays as it is; a
    later one that a scan takes for a part of it begins as much shorter.
    """
    run, known = at
    plans: Plans = []
    for found in candidates:
        told = {full.split(".")[1]: value for full, value in found.changes.items()}
        closure = _of_times(effect, kind, known + 1, set(told))
        if found.run != run or closure is None or len(starts_in(told)) > 1:
            continue
        named = {numbered(n, known + 1): v for n, v in _shortened(effect, told, values[run]).items()}
        own = {f"{effect.name}.{n}": v for n, v in named.items() if n in closure.frees}
        form = Hypothesis(effect.name, closure.frees, run, found.elsewhere, closure.name)
        plans.append((form, [Start(with_values(values, own, run), found.promise)]))
    return plans


def _of_times(effect: Effect, kind: set[str], times: int, told: set[str]) -> Closure | None:
    """Return the closure of a kind that comes so many times; None where what a scan told is of another kind."""
    found = (c for c in effect.closures if c.name in kind and len(starts_in(c.frees)) == times)
    return next((c for c in found if told <= set(c.frees)), None)


def _shortened(effect: Effect, told: dict[str, float], values: FloatArray) -> dict[str, float]:
    """Return what a scan told (its first time's numbers), as short as the strength that all times share makes it."""
    table, numbers = parameter_table(), {p.name for p in effect.parameters}
    shared = [n for n in told if effect.parameter(n).strength and numbered(n, 2) not in numbers]
    length = length_of("start")
    if not shared or length not in told:
        return told
    parts = [told[n] / (values[table.place(f"{effect.name}.{n}")] or 1.0) for n in shared]
    return {**told, length: told[length] * float(np.clip(max(parts), SHORTEST, 1.0))}
