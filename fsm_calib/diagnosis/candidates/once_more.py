"""An event of a model once more, in a recording that has it already: the scan's next moment, with numbers of its own.

A scan offers several times at once only where they stand out together. A plug that opens twice, once while the robot
rests nearly, does not; each is told by itself when the other is known. Nor do two long spells of a weak motor: a scan
makes one of both, and on top of that one it finds a pause.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

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
    there; candidates : of a scan on top of `values` (R, p). What all times share (a motor's loss) stays as it is: a
    later time that a scan takes for a part of it begins as much shorter, its opposite within a known time is a pause.
    """
    run, known = at
    plans: Plans = []
    for found in candidates:
        told = {full.split(".")[1]: value for full, value in found.changes.items()}
        closure = _of_times(effect, kind, known + 1, set(told))
        if found.run != run or closure is None or len(starts_in(told)) > 1:
            continue
        part = _part(effect, told, values[run])
        own = _later(told, part, known + 1) if part > 0.0 else _paused(effect, told, values[run], known)
        own = {f"{effect.name}.{n}": v for n, v in own.items() if n in closure.frees}
        if own:
            form = Hypothesis(effect.name, closure.frees, run, found.chance, closure.name)
            plans.append((form, [Start(with_values(values, own, run), found.promise)]))
    return plans


def _of_times(effect: Effect, kind: set[str], times: int, told: set[str]) -> Closure | None:
    """Return the closure of a kind that comes so many times; None where what a scan told is of another kind."""
    found = (c for c in effect.closures if c.name in kind and len(starts_in(c.frees)) == times)
    return next((c for c in found if told <= set(c.frees)), None)


def _part(effect: Effect, told: Mapping[str, float], values: FloatArray) -> float:
    """Return the strength that a scan told over the one that all times share [1]; 1 where they share none."""
    table, numbers = parameter_table(), {p.name for p in effect.parameters}
    shared = [n for n in told if effect.parameter(n).strength and numbered(n, 2) not in numbers]
    now = {n: float(values[table.place(f"{effect.name}.{n}")]) for n in shared}
    return max((told[n] / now[n] for n in shared if now[n] != 0.0), default=1.0)


def _later(told: Mapping[str, float], part: float, time: int) -> dict[str, float]:
    """Return what a scan told as the numbers of a later time, as much shorter as it is a part of what all share."""
    length = length_of("start")
    shorter = {length: told[length] * min(max(part, SHORTEST), 1.0)} if length in told else {}
    return {numbered(n, time): v for n, v in {**told, **shorter}.items()}


def _paused(effect: Effect, told: Mapping[str, float], values: FloatArray, known: int) -> dict[str, float]:
    """Return the numbers of the known time that a pause cuts in two; none where it lies in none of them."""
    place, begin = parameter_table().place, told["start"]
    end = begin + told[length_of("start")]
    for start in (numbered("start", time) for time in range(1, known + 1)):
        first = float(values[place(f"{effect.name}.{start}")])
        last = first + float(values[place(f"{effect.name}.{length_of(start)}")])
        if first < begin and end < last:
            later = numbered("start", known + 1)
            return {length_of(start): begin - first, later: end, length_of(later): last - end}
    return {}
