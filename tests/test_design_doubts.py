"""What data leave open beside an explanation."""

import pytest
from diagnosis_robots import recording

from fsm_calib.diagnosis.candidates.hypotheses import declared_starts, hypotheses_of
from fsm_calib.diagnosis.design.doubts import SIZES, further_effects, shown_where
from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.world2d.effects import registry


@pytest.fixture(scope="module")
def clean():
    return diagnose([recording(0, 12.0)]).decision


@pytest.fixture(scope="module")
def hidden():
    return diagnose([recording(0, 12.0, motor_deadband__offset=0.05)]).decision


def odds(decision):
    return {doubt.effect: doubt.log_odds for doubt in further_effects(decision.bank.prober)}


def test_effect_that_would_have_shown_is_doubted_less_than_before(clean):
    assert odds(clean)["motor_deadband"] < -0.5


def test_effect_that_is_there_wins(clean, hidden):
    assert odds(hidden)["motor_deadband"] > max(3.0, odds(clean)["motor_deadband"])


def test_effects_of_a_place_or_a_moment_are_no_further_effects(clean):
    assert not {"rough_floor_patch", "external_push"} & set(odds(clean))


def test_doubted_size_is_between_the_smallest_that_matters_and_the_usual_one(clean):
    doubt = next(d for d in further_effects(clean.bank.prober) if d.effect == "motor_deadband")
    usual = declared_starts(next(hypotheses_of(registry()["motor_deadband"], 1)))[0]
    full = f"motor_deadband.{doubt.parameter}"
    assert SIZES[0] <= abs(doubt.values[full] / usual[full]) <= SIZES[-1]


def test_effect_that_was_found_in_one_spot_may_hold_only_there(hidden):
    assert shown_where(hidden.bank.prober, hidden.model.fit.values)[1] == 0.0


def test_effect_that_was_found_on_much_ground_holds_elsewhere():
    found = diagnose([recording(0, 40.0, motor_deadband__offset=0.05)]).decision
    assert shown_where(found.bank.prober, found.model.fit.values)[1] < -3.0
