"""What an investigation believes: evidence as odds, what may still hide, and that promises are made by the same law."""

import math

import numpy as np
import pytest
from diagnosis_robots import recording, robot

from fsm_calib.diagnosis.design.belief import Belief, Hypothesis, beside_the_leader, without_unlikely_more
from fsm_calib.diagnosis.design.belief_of import belief_of, prior_belief
from fsm_calib.diagnosis.design.odds import DETECT, TEMPER, counted, log_odds, room_of
from fsm_calib.diagnosis.design.unseen import SHARES, size_of, unseen, ways_of
from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.diagnosis.likelihood.noise import Noise
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table


def test_evidence_counts_in_full_up_to_detection_and_by_a_third_beyond():
    assert counted(10.0, DETECT) == pytest.approx(5.0)
    assert counted(DETECT + 6.0, DETECT) == pytest.approx(0.5 * DETECT + 3.0 / TEMPER)
    assert counted(-6.0, DETECT) == pytest.approx(-3.0)


@pytest.mark.parametrize("first", [-3.0, 8.0, 40.0])
def test_odds_after_two_drives_are_those_of_both_at_once(first):
    later = counted(20.0, room_of(first, 1))
    assert log_odds(first, 1, 27) + later == pytest.approx(log_odds(first + 20.0, 1, 27))


def test_an_effect_that_is_just_detected_is_likelier_than_nothing_missing():
    assert 0.9 < 1.0 / (1.0 + math.exp(-log_odds(DETECT, 1, 27))) < 0.99


def named(name, probability, room=0.0, over=()):
    names = (*over, name) if name else ()
    return Hypothesis(names, probability, robot(), (), np.zeros((0, 0)), np.zeros(0), room, over)


def test_a_belief_weighs_a_drive_against_nothing_missing():
    belief = Belief((named("", 0.5), named("tyre_scrub", 0.5, DETECT)), 0, robot(), Noise())
    weights = belief.log_weights(np.array([[0.0, 3.0], [-50.0, 0.0]]))
    gained = weights[:, 1] - weights[:, 0]
    assert gained == pytest.approx([3.0, 0.5 * DETECT + 0.5 * (100.0 - DETECT) / TEMPER])


def test_evidence_of_faint_effects_against_nothing_missing_is_not_divided():
    rows = (named("", 0.5), named("tyre_scrub", 0.3, 5.0), named("caster_drag", 0.2, -90.0))
    tempers = Belief(rows, 0, robot(), Noise()).tempers
    assert tempers[0, 1] == tempers[1, 0] == 1.0
    assert tempers[0, 2] == tempers[1, 2] == TEMPER


def test_evidence_of_what_may_hide_beside_an_answer_counts_in_full_over_the_answer():
    answer, more = named("tyre_scrub", 0.6, -200.0), named("caster_drag", 0.2, DETECT, ("tyre_scrub",))
    belief = Belief((named("", 0.2, 0.0), answer, more), 0, robot(), Noise())
    weights = belief.log_weights(np.array([[0.0, 30.0, 34.0]])) - np.log(belief.probabilities)
    assert weights[0, 1] == pytest.approx(30.0 / TEMPER)
    assert weights[0, 2] - weights[0, 1] == pytest.approx(4.0)
    assert belief.tempers[1, 2] == belief.tempers[2, 1] == 1.0
    assert belief.tempers[0, 2] == belief.tempers[0, 1] == TEMPER


def test_an_answer_is_right_whatever_hides_beside_it_and_complete_if_nothing_does():
    answer, more = named("tyre_scrub", 0.6), named("caster_drag", 0.2, DETECT, ("tyre_scrub",))
    belief = Belief((answer, more, named("", 0.2)), 0, robot(), Noise())
    assert belief.sureness == pytest.approx(0.8)
    assert belief.completeness == pytest.approx(0.75)


def kept_of(*probabilities):
    """Return the names that are left to tell apart of two answers and of one that may have one more beside it."""
    one, other, more = probabilities
    rows = (
        named("tyre_scrub", one),
        named("caster_drag", other),
        named("floor_tilt", more, DETECT, ("tyre_scrub",)),
    )
    return len(without_unlikely_more(Belief(rows, 0, robot(), Noise()), 0.95).hypotheses)


def test_where_hardly_anything_hides_a_drive_has_only_to_tell_the_answers_apart():
    assert kept_of(0.5, 0.495, 0.005) == 2


@pytest.mark.parametrize(
    "probabilities", [(0.48, 0.47, 0.05), (0.97, 0.026, 0.004)], ids=["may hide", "one is sure"]
)
def test_else_a_drive_looks_for_what_hides_too(probabilities):
    assert kept_of(*probabilities) == 3


@pytest.mark.parametrize(("more", "count"), [(0.1, 2), (0.001, None)], ids=["may hide", "hardly"])
def test_what_is_beside_the_leader_alone_is_asked_while_something_may_hide(more, count):
    rows = (
        named("tyre_scrub", 0.5),
        named("caster_drag", 0.4),
        named("floor_tilt", more, DETECT, ("tyre_scrub",)),
    )
    rest = beside_the_leader(Belief(rows, 0, robot(), Noise()))
    assert (rest and [h.names for h in rest.hypotheses]) == (
        count and [("tyre_scrub",), ("tyre_scrub", "floor_tilt")]
    )


@pytest.mark.parametrize("name", ["motor_deadband", "floor_tilt", "payload_offset", "motor_warmup"])
def test_an_effect_may_hide_in_every_direction_at_its_typical_size(name):
    ways = ways_of(registry()[name])
    assert len(ways) > 1
    assert [size_of(registry()[name], way) for way in ways] == pytest.approx([1.0] * len(ways))


@pytest.fixture(scope="module")
def clean():
    """Diagnoses of a robot without an effect after one drive, and after three."""
    return [diagnose([recording(k, 15.0) for k in range(count)]).decision for count in (1, 3)]


def test_more_drives_leave_less_that_may_hide(clean):
    first, third = (belief_of(decision) for decision in clean)
    assert first.leader.names == third.leader.names == ()
    assert third.sureness > first.sureness > prior_belief().sureness


def hiding(decision, *names):
    """Return what the drives say of these effects where nothing was detected."""
    ranked = {r.name: r for r in decision.ranking}
    return list(unseen(decision.bank.prober, decision.base.values[0], ranked, [registry()[n] for n in names]))


def test_an_effect_that_the_drives_would_have_shown_is_as_good_as_excluded(clean):
    assert max(u.log_ratio for u in hiding(clean[1], "motor_deadband", "tyre_scrub")) < -3.0


def test_what_may_hide_is_believed_in_at_sizes_that_matter(clean):
    for u in hiding(clean[0], "motor_deadband", "floor_tilt"):
        names = [f"{u.name}.{p.name}" for p in registry()[u.name].parameters if p.strength]
        own = {n: float(u.values[parameter_table().place(n)]) for n in names}
        assert SHARES[0] - 1e-6 <= size_of(registry()[u.name], own) <= SHARES[-1] + 1e-6
