"""Once a model stands, a closure whose further numbers are nothing gives way to one that has not got them.

While names compete a larger closure may lead from where a smaller one would not (a lag opens the way to a stretch that
does without it in the end), or win by a number that what joined later took over. A closure that frees less stands in
its place where the numbers that it lacks are not far from changing nothing, and the fit without them has the larger
evidence: the sizes that stay get sharper, and no sentence tells of 0 s.
"""

from __future__ import annotations

from dataclasses import replace

from fsm_calib.diagnosis.candidates.ranked import Ranked, evidence_of
from fsm_calib.diagnosis.candidates.ranking import FIRST_STEPS
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.verdict.model import Model
from fsm_calib.world2d.effects import Closure, registry
from fsm_calib.world2d.parameters import parameter_table

FAR = 3.0  # standard deviations from what changes nothing: evidence asks for some sqrt(ln N)


def simplified(engine: Engine, model: Model) -> Model:
    """Return a model whose effects have the closures that free least."""
    for effect in model.effects:
        for closure in sorted(registry()[effect.name].competing, key=lambda c: len(c.frees)):
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
    if not _are_near_nothing(fit, effect.name, spare):
        return None
    table, declared = parameter_table(), registry()[effect.name]
    nothing = {f"{effect.name}.{name}": declared.parameter(name).null for name in spare}
    places = {table.place(name) for name in nothing}
    slots = tuple(slot for slot in fit.slots if slot.place not in places)
    simpler = engine.fit(with_values(fit.values, nothing), slots, fit.noise, steps=FIRST_STEPS, refresh=True)
    if evidence_of(fit, simpler, engine.count) > 0.0:
        return None
    return replace(effect, hypothesis=less, fit=simpler)


def _are_near_nothing(fit: Fit, name: str, spare: set[str]) -> bool:
    """Return whether numbers of an effect are not far from changing nothing, in every recording."""
    table, declared = parameter_table(), registry()[name]
    null = {table.place(f"{name}.{each}"): declared.parameter(each).null for each in spare}
    told = [
        (value - null[slot.place], variance) for slot, value, variance in fit.numbers() if slot.place in null
    ]
    return bool(told) and all(off * off <= FAR**2 * variance for off, variance in told)
