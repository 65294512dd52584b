"""Other values of numbers that no derivative leads to: choices, and numbers whose fits stay near where they start."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis, declared_starts
from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.candidates.starts import Prober, Start
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.effects.parameter import Parameter
from fsm_calib.world2d.parameters import parameter_table


def with_best_choice(
    ranked: Ranked,
    prober: Prober,
    given: Mapping[str, float],
    begun: Callable[[Hypothesis, Start], Ranked],
) -> Ranked:
    """Return the best of a fit and of those with other values of its choices and rugged numbers.

    What a start promises chose among choices so far, with phases a third of a turn apart. A scan finds a place, not
    how it is felt: a rough spot under the wheels that was begun under the body's middle lacked 575 units. Play in the
    gears has a hill for each part that the rotors may have of the inertia: 563, 566 and 581 units.

    given : choices that are known, by full name; begun : fits a form from a start, at the parent's noise.
    """
    effect, best = registry()[ranked.name], ranked
    if ranked.hypothesis.closure in {closure.name for closure in effect.extending}:
        return ranked  # it goes on with those of a smaller one
    settled = {**ranked.hypothesis.held, **given}
    for choice in effect.choices:
        if f"{effect.name}.{choice.name}" not in settled:
            others = [begun(best.hypothesis, start) for start in _chosen(best, choice, prober, given)]
            best = max([best, *others], key=lambda r: r.gain)
    for number in effect.rugged:
        if number.name in best.hypothesis.names:
            others = [begun(best.hypothesis, start) for start in _elsewhere(best, number)]
            best = max([best, *others], key=lambda r: r.gain)
    return best


def _now(ranked: Ranked, full: str) -> float:
    """Return the value of a number in a fit, in the first recording."""
    return float(ranked.fit.values[0, parameter_table().place(full)])


def _chosen(ranked: Ranked, choice: Parameter, prober: Prober, given: Mapping[str, float]) -> Iterator[Start]:
    """Yield a start for each other value of a choice: a place from where it is, others from where they promise most."""
    form, full = ranked.hypothesis, f"{ranked.name}.{choice.name}"
    for value in choice.starts:
        if value == _now(ranked, full):
            continue
        if registry()[ranked.name].scan:
            yield Start(with_values(ranked.fit.values, {full: value}, form.run), 0.0)
        else:
            yield prober.best_starts(form, declared_starts(form, {**given, full: value}), 1)[0]


def _elsewhere(ranked: Ranked, number: Parameter) -> Iterator[Start]:
    """Yield a start for each value that a number may start from but the nearest, all others as they are."""
    full = f"{ranked.name}.{number.name}"
    nearest = min(number.starts, key=lambda value: abs(value - _now(ranked, full)), default=None)
    for value in number.starts:
        if value != nearest:
            yield Start(with_values(ranked.fit.values, {full: value}, ranked.hypothesis.run), 0.0)
