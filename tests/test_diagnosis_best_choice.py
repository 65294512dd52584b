"""Numbers that no derivative leads to are tried at their other starts; choices only where the wheels leave room."""

import pytest
from diagnosis_robots import bank_of, fitted_number, recording, with_encoders

from fsm_calib.diagnosis.candidates.best_choice import with_best_choice
from fsm_calib.diagnosis.candidates.hypotheses import hypotheses_of
from fsm_calib.diagnosis.candidates.starts import Start
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.world2d.effects import registry

PLAY = {"gear_backlash__gap": 0.25, "gear_backlash__rotor": 0.9}
GAP, ROTOR, SIDE = (f"gear_backlash.{name}" for name in ("gap", "rotor", "encoder_side"))


def numbers_of(form):
    """Return the full names of what a form frees."""
    return [f"{form.effect}.{name}" for name in form.names]


@pytest.fixture(scope="module")
def bank():
    """Return the bank of a robot with play, whose motors have most of the rotating inertia."""
    return bank_of(*(recording(seed, **PLAY) for seed in (0, 1)))


@pytest.fixture(scope="module")
def form():
    return next(f for f in hypotheses_of(registry()["gear_backlash"], 2) if GAP in numbers_of(f))


def test_a_fit_that_stays_on_the_hill_of_its_start_is_tried_from_the_others(bank, form):
    far = with_values(bank.parent.values, {GAP: 0.12, ROTOR: 0.05})
    begun = bank._begun(form, Start(far, 0.0))
    found = with_best_choice(begun, bank.prober, {}, bank._begun)
    assert abs(fitted_number(found.fit, ROTOR) - 0.9) < abs(fitted_number(begun.fit, ROTOR) - 0.9)
    assert found.gain > begun.gain + 5.0


def test_where_the_encoders_sit_is_not_asked_where_there_are_none(bank):
    assert bank._measured(registry()["gear_backlash"]) == {SIDE: 0.0}


def test_where_the_encoders_sit_is_asked_where_wheels_are_measured():
    bank = bank_of(with_encoders(0, **PLAY))
    assert SIDE not in bank._measured(registry()["gear_backlash"])


def test_what_measured_wheels_leave_no_room_for_is_asked_where_there_are_none(bank):
    eccentric = registry()["wheel_eccentricity"]
    only = [p.name for p in eccentric.choices if p.without_encoders]
    assert only
    assert bank._measured(eccentric) == {}
    assert set(bank_of(with_encoders(0))._measured(eccentric)) == {f"wheel_eccentricity.{n}" for n in only}
