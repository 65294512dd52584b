"""Which effects a model ends with: what is left of two, and where a place is before others join it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis_robots import engine_of, fitted_number, recording, selector_on

from fsm_calib.diagnosis.candidates.best_choice import with_best_choice
from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis
from fsm_calib.diagnosis.candidates.ranked import Ranked, evidence_of
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.candidates.starts import Start
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.verdict import selection
from fsm_calib.diagnosis.verdict.selection import Selection, Selector
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

SPOT = {"drag": 1.0, "x": 0.12, "y": 0.05, "half_x": 0.2, "half_y": 0.2, "roundness": 1.0}


@pytest.fixture(scope="module")
def selector():
    drives = [recording(seed, **{f"rough_floor_patch__{k}": v for k, v in SPOT.items()}) for seed in (0, 1)]
    engine = engine_of(*drives)
    return Selector(engine, fit_base(engine), [], 14.0, 0.01, 4, np.random.default_rng(0))


def patch(selector, **changes):
    """Return the patch with its true numbers but for `changes`, as a candidate on top of the base robot."""
    numbers = {f"rough_floor_patch.{name}": value for name, value in (SPOT | changes).items()}
    fit = replace(selector.base, values=with_values(selector.base.values, numbers))
    fit = selector.engine.fit(fit.values, fit.slots, fit.noise, steps=2)
    return Ranked(Hypothesis("rough_floor_patch", ("x", "y", "half_x", "half_y")), fit, 100.0, 50.0)


def test_an_effect_that_is_left_of_two_is_weighed_against_the_base_robot(selector, monkeypatch):
    spot = patch(selector)
    alone = Selection((spot,), spot.fit, ((spot,), (spot,)), (spot.fit,))  # too sure to be taken out to see
    monkeypatch.setattr(Selector, "grown", lambda self, ranking: alone)
    found = selector.best_grown([spot])
    assert found.dropped == (selector.base,)
    assert found.effects[0].evidence == evidence_of(spot.fit, selector.base, selector.engine.count) > 100.0


def test_a_place_is_sought_again_before_other_effects_join_it(selector):
    beside = patch(selector, x=0.2, y=-0.02)
    (found,) = selector._polish([beside], selector.base)
    numbers = dict(zip(parameter_table().names, found.fit.values[0], strict=True))
    assert found.fit.score > beside.fit.score + 50.0
    assert np.hypot(numbers["rough_floor_patch.x"] - 0.12, numbers["rough_floor_patch.y"] - 0.05) < 0.03


def test_a_place_that_is_nowhere_crossed_is_not_taken_for_it(selector, monkeypatch):
    spot = patch(selector)
    far = replace(spot.fit, values=with_values(spot.fit.values, {"rough_floor_patch.x": 30.0}))
    monkeypatch.setattr(selection, "placed", lambda engine, fit, effects, rng: far)
    (found,) = selector._polish([spot], selector.base)
    assert fitted_number(found.fit, "rough_floor_patch.x") == pytest.approx(0.12, abs=0.1)


def test_how_a_place_is_felt_is_tried_again_where_its_fit_has_ended(selector):
    form = Hypothesis("rough_floor_patch", ("drag", "x", "y", "half_x", "half_y"), closure="dry")
    middle = {f"rough_floor_patch.{k}": v for k, v in (SPOT | {"spread": 0.0, "drag": 0.4}).items()}
    bank = Bank.on(selector.engine, selector.base)
    begun = bank._begun(form, Start(with_values(selector.base.values, middle), 0.0))
    found = with_best_choice(begun, bank.prober, {}, bank._begun)
    spread = parameter_table().place("rough_floor_patch.spread")
    assert (begun.fit.values[0, spread], found.fit.values[0, spread]) == (0.0, 1.0)
    assert found.gain > begun.gain + 50.0


def test_a_patch_of_grass_is_told_from_one_of_gravel(selector):
    grass = {f"rough_floor_patch__{k}": v for k, v in (SPOT | {"drag": 0.0, "viscous": 3.0}).items()}
    engine = engine_of(*(recording(seed, **grass) for seed in (0, 1)))
    effect = registry()["rough_floor_patch"]
    for tried, closure in ((engine, "grows with speed"), (selector.engine, "dry")):
        assert Bank.on(tried, fit_base(tried)).best_of(effect).hypothesis.closure == closure


def test_an_event_is_ranked_with_what_happened_of_its_kind_in_every_recording():
    fails = [{"motor_fault__loss_right": loss, "motor_fault__duration": 60.0} for loss in (0.15, 0.4)]
    engine = engine_of(*(recording(seed, motor_fault__start=20.0 + seed, **fails[seed]) for seed in (0, 1)))
    selector = selector_on(fit_base(engine), engine, "motor_fault")
    bank, ranking = selector.first_ranked()
    alone = bank.best_of(registry()["motor_fault"])
    starts = parameter_table().place("motor_fault.start")
    assert ranking[0].evidence > 1.1 * alone.evidence
    assert {slot.run for slot in ranking[0].fit.slots if slot.place == starts} == {0, 1}


def test_what_an_effect_excludes_is_not_asked_for_beside_it():
    names = ("skid_steer", "caster_drag", "tyre_scrub")
    catalogue = [registry()[name] for name in names]
    selector = Selector(None, None, catalogue, 14.0, 0.01, 4, np.random.default_rng(0))
    for first, others in (("skid_steer", ["tyre_scrub"]), ("tyre_scrub", ["skid_steer", "caster_drag"])):
        asked = selector.beside([SimpleNamespace(name=first)])
        assert [effect.name for effect in asked] == others
