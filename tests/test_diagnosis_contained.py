"""A form that has all numbers of another begins again where that one has ended, if it had won less."""

from dataclasses import replace

import pytest
from diagnosis_robots import bank_of, recording

from fsm_calib.diagnosis.candidates.contained import STUCK, stuck_above
from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis, hypotheses_of
from fsm_calib.diagnosis.candidates.starts import Start
from fsm_calib.world2d.effects import registry

FRICTION = {form.closure: form for form in hypotheses_of(registry()["coulomb_friction"], 2)}


@pytest.fixture(scope="module")
def alike():
    """Return dry friction alike in both wheels, as a bank has fitted it."""
    bank = bank_of(recording(0, coulomb_friction__friction=0.006))
    return bank.fit(FRICTION["both alike"], Start(bank.parent.values, 0.0))


def of(form, alike, more):
    """Return another form with `more` log-likelihood than friction alike in both wheels has."""
    return replace(alike, hypothesis=form, gain=alike.gain + more)


def test_a_form_that_won_less_than_its_part_begins_where_that_ended(alike):
    stuck = of(FRICTION["Stribeck"], alike, -2.0 * STUCK)
    ((form, start),) = stuck_above([stuck, alike])
    assert form == FRICTION["Stribeck"]
    assert start.values is alike.fit.values


@pytest.mark.parametrize(
    ("closure", "more"),
    [("Stribeck", 0.0), ("Stribeck", 5.0), ("rolling", -50.0), ("each rolls its own", -50.0)],
)
def test_a_form_that_won_as_much_or_lacks_a_number_of_it_is_left(alike, closure, more):
    assert list(stuck_above([of(FRICTION[closure], alike, more), alike])) == []


def test_the_best_fit_of_a_form_decides(alike):
    form = FRICTION["Stribeck"]
    assert list(stuck_above([of(form, alike, -90.0), of(form, alike, 1.0), alike])) == []


def test_a_form_that_holds_a_choice_is_no_part_of_one_that_does_not(alike):
    effect = registry()["misplaced_marker"]
    forms = [f for f in hypotheses_of(effect, 2) if f.held]
    free = Hypothesis(effect.name, tuple(p.name for p in effect.parameters))
    assert forms
    assert list(stuck_above([of(free, alike, -90.0), *(of(f, alike, 0.0) for f in forms)])) == []


def test_moments_are_left_to_their_scan(alike):
    one, *_, several = (f for f in hypotheses_of(registry()["external_push"], 1) if f.run == 0)
    larger = replace(several, names=tuple(dict.fromkeys((*one.names, *several.names))))
    assert list(stuck_above([of(larger, alike, -90.0), of(one, alike, 0.0)])) == []
