"""Once a model stands, a closure whose further numbers are nothing gives way to one that has not got them.

While names compete a larger closure may lead from where a smaller one would not (a lag opens the way to a stretch that
does without it in the end), or win by a number that what joined later took over. A closure that frees less stands in
its place where the fit without the numbers that it lacks has the larger evidence: the sizes that stay get sharper, and
no sentence tells of 0 s. (Standard deviations do not tell which these are: where friction holds a wheel a small step of
its number moves the roll-out by jumps, and a difference of 1.5 % between two sides was six deviations from nothing, or
a half, while the fit without it has 8 units more evidence.)
"""

from __future__ import annotations

from dataclasses import replace

from fsm_calib.diagnosis.candidates.ranked import Ranked, evidence_of
from fsm_calib.diagnosis.candidates.ranking import FIRST_STEPS
from fsm_calib.diagnosis.fitting.fit import Engine
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.verdict.model import Model
from fsm_calib.world2d.effects import Closure, registry
from fsm_calib.world2d.parameters import parameter_table


def simplified(engine: Engine, model: Model) -> Model:
    """Return a model whose effects have the closures that free least."""
    for effect in model.effects:
        declared = registry()[effect.name]
        for closure in sorted((*declared.competing, *declared.alike), key=lambda c: len(c.frees)):
            found = _by(engine, model, effect, closure)
            if found is not None:
                model = model.taking(found)
                break
    return model


def _by(engine: Engine, model: Model, effect: Ranked, closure: Closure) -> Ranked | None:
    """Return an effect by a closure that frees less; None where it says another thing, or says it worse."""
    form, fit = effect.hypothesis, model.fit
    spare = set(form.names) - set(closure.frees)
    less = replace(form, names=closure.frees, closure=closure.name)
    if not set(closure.frees) < set(form.names) or form.held != less.held:
        return None
    table, declared = parameter_table(), registry()[effect.name]
    nothing = {f"{effect.name}.{name}": declared.parameter(name).null for name in spare}
    places = {table.place(name) for name in nothing}
    slots = tuple(slot for slot in fit.slots if slot.place not in places)
    if len(slots) == len(fit.slots):
        return None
    simpler = engine.fit(with_values(fit.values, nothing), slots, fit.noise, steps=FIRST_STEPS, refresh=True)
    if evidence_of(fit, simpler, engine.count) > 0.0:
        return None
    return replace(effect, hypothesis=less, fit=simpler)
