"""An effect is spared where a neighbour of it does its job by another of its own equations.

Backward elimination takes an effect out and keeps the others' equations. What they are was decided before it came: a
caster that resisted against its velocity alone got a scrubbing tyre for company, where a caster whose two ways resist
by themselves needs none. So neighbours (effects that declare each other as rivals) are asked for all their equations
once an effect is gone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from fsm_calib.diagnosis.candidates.ranked import Ranked, evidence_of
from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.diagnosis.verdict.in_its_place import Fitting
from fsm_calib.diagnosis.verdict.swapped import bank_without, has_closures
from fsm_calib.world2d.effects import registry


def spared(
    fitting: Fitting, effects: tuple[Ranked, ...], fit: Fit, dropped: Sequence[Fit], wanted: float
) -> tuple[tuple[Ranked, ...], Fit]:
    """Return the effects, strongest first, without the weakest that a neighbour does without, and the fit of the rest.

    dropped : the fit without each of the effects; wanted : evidence by which an effect is missed.
    """
    for spare, less in reversed(list(zip(effects, dropped, strict=True))):
        for neighbour in (e for e in effects if _are_neighbours(e.name, spare.name)):
            instead = _by_another_equation(fitting, fit, less, neighbour)
            if instead is not None and evidence_of(fit, instead.fit, fitting.engine.count) < wanted:
                rest = tuple(instead if e is neighbour else e for e in effects if e is not spare)
                return rest, instead.fit
    return effects, fit


def _by_another_equation(fitting: Fitting, whole: Fit, fit: Fit, effect: Ranked) -> Ranked | None:
    """Return an effect of a fit by its best equation, as it may stand for the whole; None where it has that one."""
    bare = fitting.without(fit, effect.name)
    tried = bank_without(fitting.engine, whole, bare).best_of(registry()[effect.name])
    if tried is None or tried.hypothesis.closure == effect.hypothesis.closure:
        return None
    return replace(tried, fit=fitting.with_noise(tried.fit), evidence=effect.evidence)


def _are_neighbours(name: str, other: str) -> bool:
    """Return whether one of two effects declares the other as a rival, and the first has several equations."""
    return has_closures(registry()[name]) and declare_each_other(name, other)


def declare_each_other(name: str, other: str) -> bool:
    """Return whether one of two effects declares the other as a rival."""
    return name != other and (other in registry()[name].rivals or name in registry()[other].rivals)
