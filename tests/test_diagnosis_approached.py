"""Of an effect's forms only those that may pass its best are followed along their valley."""

from types import SimpleNamespace

from fsm_calib.diagnosis.candidates.approached import BEHIND, Approached, worth_following


def near(name, score, won=5.0):
    return Approached(SimpleNamespace(name=name, fit=SimpleNamespace(score=score)), won)


def test_the_best_form_is_followed_while_it_climbs():
    best = near("a", 100.0)
    assert worth_following([best]) == [best]


def test_a_form_whose_steps_won_nothing_is_not_followed():
    assert worth_following([near("a", 100.0, won=1.0)]) == []


def test_a_form_far_behind_is_followed_only_where_its_steps_won_as_much():
    best, slow, fast = near("a", 100.0), near("a", 99.0 - BEHIND), near("a", 99.0 - BEHIND, won=BEHIND + 2.0)
    assert worth_following([best, slow, fast]) == [best, fast]


def test_an_effect_is_not_held_against_another():
    weak = near("b", 10.0)
    assert weak in worth_following([near("a", 1000.0), weak])
