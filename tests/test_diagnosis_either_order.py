"""Two strong effects are one model in whichever order they are found."""

from dataclasses import replace

import pytest
from diagnosis_robots import engine_of, recording, selector_on

from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.verdict import selection
from fsm_calib.diagnosis.verdict.either_order import NEAR, the_other_way_round
from fsm_calib.world2d.effects import registry

PAIR = ("motor_deadband", "coulomb_friction")
HIDDEN = {"motor_deadband__offset": 0.05, "coulomb_friction__friction": 0.006}


@pytest.fixture(scope="module")
def asked():
    """Return a selector, what it finds alone of two effects that a robot has, and what it finds on top of the first."""
    engine = engine_of(*(recording(seed, **HIDDEN) for seed in (0, 1)))
    selector = selector_on(fit_base(engine), engine, *PAIR)
    _, alone = selector.first_ranked()
    second = Bank.on(engine, alone[0].fit).best_of(registry()[alone[1].name])
    return selector, alone, second


def test_a_second_effect_that_the_first_hid_is_found_before_it(asked):
    selector, alone, _ = asked
    first, second = the_other_way_round(selector, alone, [])
    assert {first.name, second.name} == set(PAIR)
    assert first.fit is second.fit
    assert first.fit.score > alone[0].fit.score + 0.5 * selector.needed
    assert second.evidence > selector.needed


def test_a_pair_that_the_usual_order_has_found_stays(asked):
    selector, alone, second = asked
    assert the_other_way_round(selector, alone, [second]) is None


def test_what_is_far_behind_the_first_is_not_asked(asked):
    selector, (first, second), _ = asked
    behind = replace(second, evidence=0.9 * NEAR * first.evidence)
    assert the_other_way_round(selector, [first, behind], []) is None


def test_what_is_no_finding_in_company_is_left(asked, monkeypatch):
    selector, alone, _ = asked
    monkeypatch.setattr(type(selector), "is_told", lambda self, ranked: ranked.name != alone[1].name)
    assert the_other_way_round(selector, alone, []) is None


def test_a_pair_of_which_one_does_without_the_other_is_asked_once_and_left(asked, monkeypatch):
    selector, alone, _ = asked
    calls = []

    def needless(finding, ranking, found):
        calls.append(ranking)
        return ranking[0], replace(ranking[1], fit=ranking[0].fit)

    monkeypatch.setattr(selection, "the_other_way_round", needless)
    grown = selector.grown(alone)
    assert len(calls) == 1
    assert {effect.name for effect in grown.effects} == set(PAIR)
