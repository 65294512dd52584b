"""Where a larger closure begins: at the fit of a smaller one of its effect that has won something.

What the smaller one has found stays, its choices with it where the larger one does not hold them otherwise; numbers
that the larger one does not have go, and then it is tried without what has stayed beside them, too. Each further
strength begins as large as those are, each further number at one of its declared starts, all of which are tried by
simulation; a distance along a direction (`Parameter.along`) at shares of what the drives cover that way. (Both wheels
of a robot oval: four numbers, seven paces and nine pairs of phases would cost every robot some 2 s.)
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import product

import numpy as np

from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis
from fsm_calib.diagnosis.candidates.starts import Prober, Start
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Closure, Effect
from fsm_calib.world2d.effects.parameter import Parameter
from fsm_calib.world2d.parameters import parameter_table


def beyond(
    prober: Prober, effect: Effect, closure: Closure, smaller: Hypothesis, values: FloatArray
) -> tuple[Hypothesis, Start]:
    """Return a closure's hypothesis and its best start from `values` (R, p), where a smaller one's fit has ended."""
    form = Hypothesis(effect.name, closure.frees, smaller.run, closure=closure.name)
    gone = {f"{effect.name}.{n}": effect.parameter(n).null for n in smaller.names if n not in closure.frees}
    bases = [{**gone, **form.held}]
    if gone:  # what stays may have made up for what goes
        strengths = [n for n in smaller.names if effect.parameter(n).strength]
        bases.append({**bases[0], **{f"{effect.name}.{n}": effect.parameter(n).null for n in strengths}})
    choices = [_on_the_way(prober, effect, c) for c in _further(effect, closure, smaller, values)]
    tried = [with_values(values, {**base, **choice}, form.run) for base in bases for choice in choices]
    starts = [Start(there, prober.gain(prober.columns(there))) for there in tried]
    return form, max(starts, key=lambda start: start.promise)


def _further(
    effect: Effect, closure: Closure, smaller: Hypothesis, values: FloatArray
) -> Iterable[dict[str, float]]:
    """Yield the combinations of starts of what a closure frees beyond a smaller one, by full name."""
    further = [effect.parameter(name) for name in closure.frees if name not in smaller.names]
    size = _size(effect, smaller, values)
    begun = [p for p in further if p.strength or p.starts]  # others stay where they are
    for choice in product(*(_starts(p, p.null + size) for p in begun)):
        yield {f"{effect.name}.{p.name}": value for p, value in zip(begun, choice, strict=True)}


def _on_the_way(prober: Prober, effect: Effect, choice: dict[str, float]) -> dict[str, float]:
    """Return a choice whose distances along a direction lie by their shares of what the drives cover that way [m]."""
    placed = {f"{effect.name}.{p.name}": f"{effect.name}.{p.along}" for p in effect.parameters if p.along}
    metres = {
        name: _covered(prober, choice[angle], choice[name])
        for name, angle in placed.items()
        if name in choice and angle in choice
    }
    return choice | metres


def _covered(prober: Prober, angle: float, share: float) -> float:
    """Return how far from the origin along an angle [rad] a share of what the drives cover that way lies [m]."""
    way = np.cos(angle), np.sin(angle)
    reached = np.concatenate([s.prepared.reference[:, :2] @ way for s in prober.simulators])
    return float(reached.min() + share * np.ptp(reached))


def _starts(p: Parameter, size: float) -> tuple[float, ...]:
    """Return where a number begins: a strength as large as others are, if its fits stay near where they start (rugged)
    at its declared starts, too.
    """
    return ((size, *p.starts) if p.rugged else (size,)) if p.strength else p.starts


def _size(effect: Effect, smaller: Hypothesis, values: FloatArray) -> float:
    """Return how far the smaller closure's strengths are from null, in the mean."""
    table = parameter_table()
    strengths = [effect.parameter(name) for name in smaller.names if effect.parameter(name).strength]
    return float(
        np.mean([values[:, table.place(f"{effect.name}.{p.name}")].mean() - p.null for p in strengths])
    )
