"""Once a model stands, the equations of its effects are made more exact where the recordings ask for it.

A closure that refines (`Closure.refines`) would compete with other names for what they explain better; beside an effect
that has been found without it, it only says more exactly how that effect acts.
"""

from __future__ import annotations

from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis, slots_of
from fsm_calib.diagnosis.candidates.polish import polished
from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.candidates.ranking import FIRST_STEPS
from fsm_calib.diagnosis.fitting.base import noise_names
from fsm_calib.diagnosis.fitting.fit import Engine
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.replay.simulator import scale_of
from fsm_calib.diagnosis.verdict.model import Model
from fsm_calib.world2d.effects import Closure, registry


def refined(engine: Engine, model: Model, least: float) -> Model:
    """Return a model with every refinement of its effects that adds at least the evidence `least`."""
    for effect in model.effects:
        for closure in registry()[effect.name].refining:
            found = _with(engine, model, effect, closure)
            if found.evidence >= least:
                model = model.taking(found)
    return model


def _with(engine: Engine, model: Model, effect: Ranked, closure: Closure) -> Ranked:
    """Return an effect's closure on top of the whole model, its further numbers from their declared starts."""
    declared = registry()[effect.name]
    form = Hypothesis(effect.name, closure.frees, effect.hypothesis.run, closure=closure.name)
    further = [declared.parameter(name) for name in closure.frees if name not in effect.hypothesis.names]
    start = with_values(
        model.fit.values, {f"{effect.name}.{p.name}": p.starts[0] for p in further if p.starts}
    )
    free = slots_of(form, len(engine.simulators), scale_of(engine.simulators[0]))
    taken = {(slot.place, slot.run) for slot in model.fit.slots}
    slots = (*model.fit.slots, *(slot for slot in free if (slot.place, slot.run) not in taken))
    found = Ranked(form, engine.fit(start, slots, model.fit.noise, steps=FIRST_STEPS), 0.0, 0.0)
    return polished(engine, found, model.fit, noise_names(engine.simulators))
