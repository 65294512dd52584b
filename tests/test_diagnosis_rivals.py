"""Effects are ranked once on each fit, whoever asks, and the second answer is the first."""

import pytest
from diagnosis_robots import engine_of, recording

from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.candidates.rivals import Banks, Rivals
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.world2d.effects import registry

NAMES = ("motor_deadband", "coulomb_friction", "battery_sag")
RIVALS = [registry()[name] for name in NAMES]


@pytest.fixture(scope="module")
def robot():
    """Return the engine and the base of a robot with a dead zone."""
    engine = engine_of(*(recording(seed, motor_deadband__offset=0.04) for seed in (0, 1)))
    return engine, fit_base(engine)


@pytest.fixture
def fitted(monkeypatch):
    """Return a list of the forms that have been fitted since."""
    forms, begun = [], Bank._begun
    monkeypatch.setattr(
        Bank, "_begun", lambda bank, form, *given: forms.append(form) or begun(bank, form, *given)
    )
    return forms


def told(ranking):
    return [(ranked.name, ranked.evidence) for ranked in ranking]


def test_what_was_ranked_on_a_fit_is_not_fitted_again(robot, fitted):
    rivals = Rivals(RIVALS)
    first = rivals.ranked_on(*robot)
    fitted.clear()
    assert told(rivals.ranked_on(*robot)) == told(first)
    assert not fitted


def test_effects_that_are_asked_later_join_those_that_were_asked(robot, fitted):
    banks = Banks()
    few = Rivals(RIVALS, banks).among(NAMES[:1])
    few.ranked_on(*robot)
    fitted.clear()
    together = Rivals(RIVALS, banks).ranked_on(*robot)
    assert NAMES[0] not in {form.effect for form in fitted}
    assert told(together) == told(Rivals(RIVALS).ranked_on(*robot))


def test_another_fit_is_asked_anew(robot, fitted):
    engine, base = robot
    rivals = Rivals(RIVALS[:1])
    rivals.ranked_on(engine, base)
    fitted.clear()
    rivals.ranked_on(engine, fit_base(engine))
    assert fitted


def test_who_asks_next_learns_which_starts_are_distinct(robot):
    engine, base = robot
    banks, distinct = Banks(), {}
    Rivals(RIVALS, banks).ranked_on(engine, base)
    bank = banks.on(engine, base, distinct)
    assert bank.distinct is distinct
    assert {form.effect for form in distinct} == set(NAMES)
