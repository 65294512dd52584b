"""A closure whose further numbers are nothing gives way to one that has not got them."""

import pytest
from diagnosis_robots import engine_of, recording

from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.verdict.model import Model
from fsm_calib.diagnosis.verdict.simplified import simplified
from fsm_calib.world2d.effects import registry


def model_of(closure, **changes):
    """Return a model of a robot with `changes` whose dry friction is fitted by a closure."""
    engine = engine_of(*(recording(seed, **changes) for seed in (0, 1)))
    base = fit_base(engine)
    bank = Bank.on(engine, base)
    effect = registry()["coulomb_friction"]
    form = Hypothesis("coulomb_friction", effect.closure(closure).frees, closure=closure)
    starts = next(starts for hypothesis, starts in bank.plans(effect) if hypothesis == form)
    found = bank.fit(form, starts[0])
    return engine, Model((found,), found.fit, None, (), None)


def test_friction_that_is_alike_on_both_sides_is_told_so():
    engine, model = model_of("each its own", coulomb_friction__friction=0.004)
    simple = simplified(engine, model)
    (effect,) = simple.effects
    assert (effect.hypothesis.closure, effect.hypothesis.names) == ("both alike", ("friction",))
    assert simple.fit.score == pytest.approx(model.fit.score, abs=5.0)
    assert len(simple.fit.slots) == len(model.fit.slots) - 1
    assert model.effects[0].hypothesis.closure == "each its own"


def test_what_is_needed_stays():
    uneven = {"coulomb_friction__friction": 0.004, "coulomb_friction__difference": 0.002}
    engine, model = model_of("each its own", **uneven)
    assert simplified(engine, model).effects[0].hypothesis.closure == "each its own"
