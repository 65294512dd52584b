"""What speaks for a name and against it: what it adds, its rivals, one law in all drives, forms in its place."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis_robots import engine_of, judged, recording
from scipy.stats import norm

from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis
from fsm_calib.diagnosis.candidates.polish import polished
from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.base import fit_base, noise_names
from fsm_calib.diagnosis.proof import gap
from fsm_calib.diagnosis.proof.form_test import Contest, Remainder, contest
from fsm_calib.diagnosis.proof.gap import LOGISTIC, Gap, block_sums, gap_between, gap_where_it_acts
from fsm_calib.diagnosis.proof.heldout import noise_floor, squared_error
from fsm_calib.diagnosis.proof.one_law import OneLaw, one_law
from fsm_calib.diagnosis.verdict import cross_examined
from fsm_calib.diagnosis.verdict.posterior import belief_of, shape_probability
from fsm_calib.diagnosis.verdict.selection import Selector
from fsm_calib.diagnosis.verdict.support import RivalGap, Support
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameters

PAIR = {"floor_tilt__slope_x": 0.03, "floor_tilt__slope_y": -0.02, "motor_deadband__offset": 0.04}
CATALOGUE = ("floor_tilt", "motor_deadband", "command_delay", "motor_gain_curve")


def engine_seconds(engine):
    return sum(int(np.ptp(s.prepared.time)) + 1 for s in engine.simulators)


def support(rivals=(), moved=0.0, instead=-100.0, beside=-10.0, added=400.0, stand_in=None):
    effect = Ranked(Hypothesis("floor_tilt", ("slope_x",)), None, added, 0.5 * added)
    gaps = tuple(RivalGap(name, Gap(evidence, 20.0, 60), None) for name, evidence in rivals)
    forms = Contest(instead, (), beside, (), instead if stand_in is None else stand_in, added)
    return Support(effect, None, Gap(added, 30.0, 60), 1.0, gaps, OneLaw(moved, ()), forms)


def fitted(engine, base, name):
    (ranked,) = Bank.on(engine, base).rank([registry()[name]])
    return polished(engine, ranked, base, noise_names(engine.simulators)).fit


@pytest.fixture(scope="module")
def tilted():
    changes = {"floor_tilt__slope_x": 0.03, "floor_tilt__slope_y": -0.02}
    engine = engine_of(*(recording(seed, **changes) for seed in (0, 1)))
    base = fit_base(engine)
    return engine, base, fitted(engine, base, "floor_tilt")


def test_errors_of_two_fits_are_told_in_one_unit(tilted):
    engine, base, fit = tilted
    unit = noise_floor(engine.simulators, fit)
    before, after = (squared_error(engine.simulators, f, unit) for f in (base, fit))
    assert after == pytest.approx(
        2.9, rel=0.5
    )  # two axes of position and one heading of unit noise, medians as units
    assert before > 2.0 * after


def test_a_name_that_nothing_speaks_against_is_nearly_sure():
    assert belief_of(support()).probability > 0.95


def test_an_event_is_half_as_sure_where_a_law_that_always_holds_does_as_well():
    """A motor that was weak as long as one command was held, on which a wheel stood, and on no other."""
    span = Ranked(Hypothesis("motor_fault", ("loss_left", "start", "duration"), 0), None, 160.0, 80.0)
    unlike, alike = (replace(support(instead=i, added=160.0), effect=span) for i in (-300.0, 0.0))
    assert belief_of(alike).probability == pytest.approx(0.5 * belief_of(unlike).probability, abs=0.02)
    assert belief_of(support(instead=0.0)).probability > 0.9  # a lasting law may be another than ours


def test_a_far_rival_lowers_the_probability_and_a_near_one_joins_the_set():
    far, near = belief_of(support([("carpet_nap", 60.0)])), belief_of(support([("carpet_nap", 5.0)]))
    assert far.among == ("floor_tilt",)
    assert far.probability < belief_of(support()).probability
    assert near.among == ("floor_tilt", "carpet_nap")


def test_each_share_that_speaks_against_the_shape_lowers_its_probability():
    sure = shape_probability(support())
    assert shape_probability(support(beside=400.0, instead=0.0)) < 0.5 * sure
    assert shape_probability(support(instead=800.0)) < 0.5 * sure
    assert shape_probability(support(moved=1.5)) < 0.5 * sure


def test_shares_count_and_not_sizes():
    small, large = support(beside=20.0), support(beside=200.0, added=4000.0, instead=-1000.0)
    assert shape_probability(small) == pytest.approx(shape_probability(large))


def test_a_remainder_that_could_not_do_the_names_job_is_not_held_against_it():
    unlike, alike = support(beside=300.0, instead=-500.0), support(beside=300.0, instead=250.0)
    assert shape_probability(unlike) == pytest.approx(shape_probability(support()))
    assert shape_probability(alike) < 0.5


def test_forms_that_could_do_the_names_job_but_explain_nothing_that_is_left_are_not_held_against_it():
    other_kind = support(beside=300.0, instead=0.0, stand_in=-400.0)
    alike = support(beside=300.0, instead=0.0)
    odds_of_other, odds_of_alike = (p / (1.0 - p) for p in map(shape_probability, (other_kind, alike)))
    assert odds_of_other > 10.0 * odds_of_alike


def test_what_stands_in_for_a_name_is_of_the_quantities_that_are_left(tilted):
    engine, base, fit = tilted
    left = replace(Remainder.of(engine, fit), beside=50.0)
    late, place = (
        contest(replace(left, quantities=(quantity,)), base, ["floor_tilt"])
        for quantity in ("how late it arrives", "the place")
    )
    assert late.stand_in < place.stand_in <= place.instead


@pytest.mark.parametrize(("spread", "believed"), [(300.0, False), (5.0, True)])
def test_an_event_may_be_what_shows_most_of_any_remainder_unless_it_stands_out(spread, believed):
    push = Ranked(Hypothesis("external_push", ("impulse_x",)), None, 400.0, 200.0)
    event = replace(support(beside=300.0, instead=-500.0), effect=push, added=Gap(400.0, spread, 60))
    assert (shape_probability(event) > 0.5) is believed


def test_what_cannot_be_asked_says_nothing_against_a_name():
    assert shape_probability(support(moved=math.nan)) == shape_probability(support(moved=0.0))


def test_an_even_gap_is_even_odds_and_a_wide_spread_tempers():
    assert Gap(0.0, 5.0, 60).probability == pytest.approx(0.5)
    assert 0.5 < Gap(20.0, 40.0, 60).probability < Gap(20.0, 5.0, 60).probability


def test_few_seconds_convince_less_than_many_and_many_as_the_normal_curve_does():
    few, many = Gap(60.0, 30.0, 4), Gap(60.0, 30.0, 5000)
    assert 0.9 < few.probability < 0.95 < many.probability
    assert many.probability == pytest.approx(norm.cdf(60.0 / math.hypot(30.0, LOGISTIC)), abs=1e-4)


def test_where_the_seconds_agree_it_does_not_matter_how_few_they_are():
    assert Gap(10.0, 0.0, 3).probability == pytest.approx(norm.cdf(10.0 / LOGISTIC), abs=1e-6)


def test_blocks_add_up_to_the_likelihood(tilted):
    engine, base, _ = tilted
    assert block_sums(engine, base).sum() == pytest.approx(base.log_likelihood, rel=1e-9)


def test_a_gap_is_the_evidence_that_the_ranking_uses(tilted):
    engine, base, fit = tilted
    expected = 2.0 * (fit.score - base.score) - 2.0 * np.log(engine.count)
    assert gap_between(engine, fit, base).evidence == pytest.approx(expected)


def test_a_model_has_no_gap_to_itself(tilted):
    engine, base, _ = tilted
    assert gap_between(engine, base, base) == Gap(0.0, 0.0, engine_seconds(engine))


def test_the_spread_of_a_gap_is_that_of_a_sum_of_as_many_blocks_that_vary_alike(monkeypatch):
    sums = {"first": np.array([4.0, 8.0, 6.0]), "second": np.array([3.0, 3.0, 3.0])}
    monkeypatch.setattr(gap, "block_sums", lambda engine, fit: sums[fit.name])
    first, second = (SimpleNamespace(name=name, slots=(), score=0.0) for name in sums)
    expected = 2.0 * math.sqrt(3 * np.var([1.0, 5.0, 3.0], ddof=1))
    assert gap_between(SimpleNamespace(count=9), first, second).spread == pytest.approx(expected)


@pytest.mark.parametrize(
    ("acts", "left"), [([0.0, 0.0, 4.0, 2.0], 0.0), ([3.0, 3.0, 0.0, 0.0], 1.0), ([1.0, 1.0, 1.0, 1.0], 1.0)]
)
def test_evidence_that_comes_as_the_effect_acts_is_not_uneven(monkeypatch, acts, left):
    sums = {"whole": np.array([3.0, 3.0, 11.0, 7.0]), "less": np.full(4, 3.0)}
    monkeypatch.setattr(gap, "block_sums", lambda engine, fit: sums[fit.name])
    monkeypatch.setattr(gap, "_changes", lambda engine, whole, less: np.array(acts))
    whole, less = (SimpleNamespace(name=name, slots=(), score=0.0) for name in sums)
    engine = SimpleNamespace(count=9)
    expected = left * gap_between(engine, whole, less).spread
    assert gap_where_it_acts(engine, whole, less).spread == pytest.approx(expected, abs=1e-6)


def test_a_motor_that_fails_for_some_seconds_adds_its_evidence_there():
    fault = {"motor_fault__loss_left": 0.1, "motor_fault__start": 12.0, "motor_fault__duration": 8.0}
    engine = engine_of(recording(0, **fault), recording(1))
    base = fit_base(engine)
    whole = fitted(engine, base, "motor_fault")
    plain, where_it_acts = gap_between(engine, whole, base), gap_where_it_acts(engine, whole, base)
    assert where_it_acts.evidence == plain.evidence
    assert where_it_acts.spread < 0.85 * plain.spread


def sums_of(monkeypatch, scored):
    """Return the sums of blocks of a recording of 3.1 s with four rows, whose densities are 1, 2, 4 and 8."""
    monkeypatch.setattr(gap, "log_density", lambda residual, log_scale, nu: residual)
    prepared = SimpleNamespace(time=np.array([100.5, 101.0, 101.6, 103.6]), scored=np.array(scored)[:, None])
    densities = np.array([1.0, 2.0, 4.0, 8.0])[scored]
    whitener = SimpleNamespace(prepared=prepared, residual=lambda simulated: simulated, log_scale=0.0)
    engine = SimpleNamespace(whiteners=lambda noise: (whitener,), nu=4.0)
    return block_sums(engine, SimpleNamespace(noise=None, simulated=(densities,))).tolist()


def test_blocks_are_seconds_since_a_recording_began(monkeypatch):
    assert sums_of(monkeypatch, [True] * 4) == [3.0, 4.0, 0.0, 8.0]


def test_seconds_at_the_end_in_which_nothing_is_scored_are_blocks_too(monkeypatch):
    assert sums_of(monkeypatch, [True, True, True, False]) == [3.0, 4.0, 0.0, 0.0]


def test_a_true_effect_is_one_law_in_all_drives(tilted):
    engine, base, fit = tilted
    assert abs(one_law(engine, base, fit, "floor_tilt").moved) < 0.1


def test_an_effect_of_another_size_in_each_drive_is_not_one_law():
    steep, gentle = {"floor_tilt__slope_x": 0.04}, {"floor_tilt__slope_x": 0.02}
    engine = engine_of(recording(0, **steep), recording(1, **gentle))
    base = fit_base(engine)
    assert one_law(engine, base, fitted(engine, base, "floor_tilt"), "floor_tilt").moved > 0.2


def test_one_recording_cannot_tell_whether_it_is_one_law(tilted):
    engine = engine_of(recording(0, floor_tilt__slope_x=0.03))
    base = fit_base(engine)
    assert math.isnan(one_law(engine, base, fitted(engine, base, "floor_tilt"), "floor_tilt").moved)


def test_two_effects_are_both_named():
    decision = judged(CATALOGUE, **PAIR)
    assert decision.outcome == "explained"
    assert {b.name for b in decision.named} == {"floor_tilt", "motor_deadband"}


def test_an_effect_that_another_makes_needless_goes(tilted):
    engine, base, fit = tilted
    selector = Selector(
        engine,
        base,
        [registry()["floor_tilt"], registry()["carpet_nap"]],
        14.0,
        0.01,
        3.5,
        4,
        np.random.default_rng(0),
    )
    (nap,) = Bank.on(engine, base).rank([registry()["carpet_nap"]])
    tilt = Ranked(Hypothesis("floor_tilt", ("slope_x", "slope_y")), fit, 0.0, 0.0)
    (both,) = [r for r in Bank.on(engine, nap.fit).rank([registry()["floor_tilt"]])]
    kept = selector._pruned((nap, replace(tilt, fit=both.fit)), both.fit, ((nap,),), 14.0)
    assert [e.name for e in kept.effects] == ["floor_tilt"]


def test_the_nearest_neighbour_of_an_effect_is_asked_whatever_it_had_alone(monkeypatch):
    asked = []

    def fit(hypothesis, start):
        asked.append(hypothesis.effect)
        return ranked(hypothesis.effect, 5.0)

    def ranked(name, evidence):
        values = np.array([parameters()])
        return Ranked(Hypothesis(name, ()), SimpleNamespace(values=values, score=0.0), evidence, evidence)

    bank = SimpleNamespace(
        fit=fit,
        parent=SimpleNamespace(slots=()),
        best_of=lambda effect: None,
        side_by_side=lambda work, things: [work(thing) for thing in things],
    )
    monkeypatch.setattr(cross_examined.Bank, "on", lambda engine, fit: bank)
    nap, slope = ranked("carpet_nap", 100.0), ranked("floor_tilt", 1.0)
    others = tuple(ranked(name, 60.0) for name in ("motor_deadband", "gear_backlash", "tyre_scrub"))
    faint = ranked("payload_offset", 2.0)
    selection = SimpleNamespace(
        effects=(nap, ranked("sensor_yaw", 80.0)), rankings=((nap, *others), (slope, faint)), fit=nap.fit
    )
    cross_examined._in_its_place(None, selection, nap, nap.fit)
    assert asked[0] == "floor_tilt"
    assert "payload_offset" not in asked
