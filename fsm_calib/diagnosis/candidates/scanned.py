"""The candidates of a scan become starts of fits: a place or a moment, with the strength that the data ask for."""

from __future__ import annotations

from collections.abc import Mapping

from fsm_calib.diagnosis.candidates.candidate import FAINT, Candidate
from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis, asked_for, declared_starts
from fsm_calib.diagnosis.candidates.outstanding import RARE
from fsm_calib.diagnosis.candidates.scan import Scanner
from fsm_calib.diagnosis.candidates.starts import Prober, Start
from fsm_calib.diagnosis.fitting.slot import ALL_RUNS
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.world2d.effects import Closure, Effect

WORTH_FITTING = 0.6  # of the best candidate's promise: a scan's order is right to about that

Plan = tuple[Hypothesis, list[Start] | None]
"""A form with where it starts; None where that is to be sought."""
Plans = list[tuple[Hypothesis, list[Start]]]
"""Forms with where each starts."""


def scanned(prober: Prober, scanner: Scanner, effect: Effect) -> Plans:
    """Turn what a scan finds of an effect into starts, with strengths tried by simulation.

    What came alike in every recording as chance hardly does is tried however much one drive by itself promises.
    """
    candidates = scanner.candidates(effect)
    plans = []
    best = max((c.promise for c in candidates), default=0.0)
    wanted = max(WORTH_FITTING * best, min(best, FAINT))
    for candidate in candidates:
        sure = bool(candidate.each) and candidate.chance <= RARE
        if (candidate.promise < wanted and not sure) or scanner.hopeless(candidate.promise):
            continue
        if candidate.each:
            plans.append(_alike(prober, effect, candidate))
            continue
        given = {n.split(".")[1] for n in candidate.changes}
        for closure in asked_for(effect, given):
            names = closure.frees
            strengths = {p.name for p in effect.parameters if p.strength}
            if (given & strengths) - set(names):
                continue
            if given & strengths and len(set(names) & strengths) > len(given & strengths):
                continue  # the larger form is tried only where the scan asked for it
            hypothesis = Hypothesis(effect.name, names, candidate.run, candidate.chance, closure.name)
            if any(candidate.changes.get(n, value) != value for n, value in hypothesis.held.items()):
                continue  # the scan looked for another closure
            choices = declared_starts(hypothesis, candidate.changes)
            choices = [{**choice, **candidate.changes, **hypothesis.held} for choice in choices]
            plans.append((hypothesis, prober.best_starts(hypothesis, choices, 1)))
    return plans


def _alike(prober: Prober, effect: Effect, candidate: Candidate) -> tuple[Hypothesis, list[Start]]:
    """Return the form of an event that comes alike in every recording, with its start: its scan has found the size."""
    told = {*candidate.changes, *candidate.each[0]}
    closure = next(c for c in effect.alike if _is_told(effect, c, told, candidate.changes))
    form = Hypothesis(effect.name, closure.frees, ALL_RUNS, candidate.chance, closure.name)
    values = with_values(prober.parent.values, candidate.changes)
    for run, own in enumerate(candidate.each):
        values = with_values(values, own, run)
    return form, [Start(values, candidate.promise)]


def _is_told(effect: Effect, closure: Closure, told: set[str], changes: Mapping[str, float]) -> bool:
    """Return whether a scan tells all that a closure frees and nothing else, and holds what that one holds."""
    held = {f"{effect.name}.{name}": value for name, value in closure.fixes.items()}
    free = {f"{effect.name}.{name}" for name in closure.frees}
    return told == free | set(held) and all(changes[name] == value for name, value in held.items())
