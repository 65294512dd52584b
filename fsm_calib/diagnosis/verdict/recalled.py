"""What an earlier answer had found is asked again with what has been recorded since, from where it was found.

A search over a floor begins anew with every further recording, and it may miss what it had found: a slippery spot was
in the answer after four drives (0.97), not after five, again after six (0.99), and lost in the end. More recordings
make a true effect likelier. So where a name of the earlier answer is not in the new one, the new recordings are fitted
from the numbers that it had, and what grows from there stands if it is likelier. Events happened once and are no part
of it, nor is what has a number for each recording (the phase of a wheel).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis, slots_of
from fsm_calib.diagnosis.candidates.ranked import Ranked, evidence_of
from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.diagnosis.fitting.slot import ALL_RUNS
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.replay.simulator import scale_of
from fsm_calib.diagnosis.verdict.selection import Selection, Selector
from fsm_calib.world2d.effects import Effect, registry
from fsm_calib.world2d.parameters import parameter_table


@dataclass(frozen=True)
class Finding:
    """An effect of an earlier answer: the form that it had, and its numbers by full name."""

    hypothesis: Hypothesis
    numbers: Mapping[str, float]


def findings_of(effects: Sequence[Ranked], fit: Fit, named: Sequence[str]) -> tuple[Finding, ...]:
    """Return what a model with these effects, fitted so, has found under the names that are said."""
    table = parameter_table()
    return tuple(
        Finding(r.hypothesis, {table.names[i]: float(fit.values[0, i]) for i in table.of_effect(r.name)})
        for r in effects
        if r.name in named and r.hypothesis.run == ALL_RUNS and _lasts(registry()[r.name])
    )


def likelier_if_recalled(
    selector: Selector,
    earlier: Sequence[Finding],
    ranking: Sequence[Ranked],
    selection: Selection | None = None,
) -> Selection | None:
    """Return what grows from an earlier answer where that is likelier than a selection; else the selection as given.

    selection : None where nothing was detected; then what grows must be.
    """
    if not earlier:
        return selection
    asked = {effect.name for effect in selector.catalogue}
    earlier = [finding for finding in earlier if finding.hypothesis.effect in asked]
    has = {effect.name for effect in selection.effects} if selection else set()
    if all(finding.hypothesis.effect in has for finding in earlier):
        return selection
    fit, effects = _fitted_from(selector, earlier)
    rankings = selection.rankings if selection else (tuple(ranking) or effects,)
    other = selector.grown_from(effects, fit, rankings)
    rival, needed = (selection.fit, 0.0) if selection else (selector.base, selector.needed)
    likelier = evidence_of(other.fit, rival, selector.engine.count) > needed
    return other if likelier and other.effects[0].evidence >= selector.needed else selection


def _fitted_from(selector: Selector, earlier: Sequence[Finding]) -> tuple[Fit, tuple[Ranked, ...]]:
    """Return the base robot with all that was found, fitted from the numbers it had, and each of it."""
    engine, base = selector.engine, selector.base
    runs, scale = len(engine.simulators), scale_of(engine.simulators[0])
    values = with_values(base.values, {k: v for finding in earlier for k, v in finding.numbers.items()})
    slots = [slot for finding in earlier for slot in slots_of(finding.hypothesis, runs, scale)]
    fit = selector.with_noise(engine.fit(values, (*base.slots, *slots), base.noise))
    won, gain = evidence_of(fit, base, engine.count), fit.score - base.score
    return fit, tuple(Ranked(finding.hypothesis, fit, won, gain) for finding in earlier)


def _lasts(effect: Effect) -> bool:
    """Return whether an effect acts in every recording, with the same numbers."""
    return effect.scan != "time" and not any(p.per_recording for p in effect.parameters)
