"""An effect that joined beside its rival takes that one's place where it does the whole job alone."""

from types import SimpleNamespace

import numpy as np
from diagnosis_robots import engine_of, recording

from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis
from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.verdict import swapped as swaps
from fsm_calib.diagnosis.verdict.selection import Selector
from fsm_calib.diagnosis.verdict.swapped import swapped
from fsm_calib.world2d.effects import registry

TRUE = {"gear_backlash__gap": 0.3, "coulomb_friction__rolling": 0.08}


def test_rolling_resistance_takes_the_place_of_a_dragging_caster_beside_it():
    drives = [recording(seed, **TRUE) for seed in (0, 1)]
    engine = engine_of(*drives)
    selector = Selector(engine, fit_base(engine), [], 14.0, 0.01, 4, np.random.default_rng(0))
    play = Bank.on(engine, selector.base).best_of(registry()["gear_backlash"])
    beside = Bank.on(engine, play.fit)
    caster, rolling = (beside.best_of(registry()[n]) for n in ("caster_drag", "coulomb_friction"))
    joining = Bank.on(engine, selector.with_noise(caster.fit)).best_of(registry()["coulomb_friction"])
    rankings = ((play,), (caster, rolling), (joining,))
    effects, fit = swapped(selector, (play, caster, joining), joining.fit, rankings)
    assert [e.name for e in effects] == ["gear_backlash", "coulomb_friction"]
    assert effects[1].hypothesis.closure in {"rolling", "each rolls its own"}  # one law, of both or of each
    assert fit.score > joining.fit.score


def _polished(selector, parent, name):
    """Return an effect on top of a parent, fitted to its end as the selector fits those that lead."""
    return selector._polish([Bank.on(selector.engine, parent).best_of(registry()[name])], parent)[0]


def test_the_rivals_asked_are_those_of_the_round_that_an_effect_won():
    """A nap that joined second and stands first, being stronger, gives way to the slope of its own round."""
    true = {"coulomb_friction__friction": 0.01, "floor_tilt__slope_x": 0.02, "command_delay__delay": 0.1}
    engine = engine_of(*(recording(seed, **true) for seed in (0, 1)))
    selector = Selector(engine, fit_base(engine), [], 14.0, 0.01, 4, np.random.default_rng(0))
    friction = _polished(selector, selector.base, "coulomb_friction")
    nap, tilt = (_polished(selector, friction.fit, name) for name in ("carpet_nap", "floor_tilt"))
    joining = _polished(selector, nap.fit, "command_delay")
    rankings = ((friction,), (nap, tilt), (joining,))
    effects, _ = swapped(selector, (nap, friction, joining), joining.fit, rankings)
    assert [e.name for e in effects] == ["floor_tilt", "coulomb_friction", "command_delay"]


def test_each_rival_is_tried_in_the_model_as_it_was_given(monkeypatch):
    """A second rival beside the first, which had just entered, won by what that one explains: a ghost."""
    engine = SimpleNamespace(count=1000)
    given, less, first, second = (SimpleNamespace(score=s, size=4) for s in (100.0, 0.0, 150.0, 120.0))
    earlier, tilt, rough = (
        Ranked(Hypothesis(name, ()), given, 50.0, 50.0)
        for name in ("sensor_yaw", "floor_tilt", "sensor_offset")
    )
    fits = {"floor_tilt": first, "sensor_offset": second}
    bank = SimpleNamespace(
        best_of=lambda effect: Ranked(Hypothesis(effect.name, ()), fits[effect.name], 50.0, 50.0)
    )
    tried_in = []
    monkeypatch.setattr(swaps, "bank_without", lambda *asked: bank)
    monkeypatch.setattr(swaps, "on_its_own_ground", lambda bank, rival, whole, name: tried_in.append(whole))
    fitting = SimpleNamespace(engine=engine, without=lambda fit, name: less)
    effects, fit = swaps._with_another(fitting, (earlier,), given, 0, [tilt, rough])
    assert [e.name for e in effects] == ["floor_tilt"]
    assert fit is first
    assert tried_in == [given, given]
