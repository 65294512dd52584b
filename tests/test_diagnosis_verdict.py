"""Whole diagnoses of simulated robots with a small catalogue: names, matches, abstention, proof."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis_robots import judged, recording

from fsm_calib.commands.verdict_lines import summary_lines
from fsm_calib.diagnosis.candidates.distinct import apart
from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis
from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.candidates.scan_areas import Area, settled
from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.diagnosis.proof.gates import DEFAULT_GATES, adequacy
from fsm_calib.diagnosis.verdict.explain import _sentences
from fsm_calib.diagnosis.verdict.model import Model
from fsm_calib.diagnosis.verdict.systematic_error import model_spread, with_doubt
from fsm_calib.diagnosis.verdict.verdict import Estimate
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

SMALL = ("motor_deadband", "motor_gain_curve", "command_delay", "floor_tilt")
OTHERS = tuple(name for name in registry() if name not in SMALL)


@pytest.fixture(scope="module")
def deadband():
    trains = [recording(seed, motor_deadband__offset=0.04) for seed in (0, 1)]
    return diagnose(trains, [recording(2, motor_deadband__offset=0.04)], without=OTHERS)


def test_deadband_is_named_with_its_width(deadband):
    (effect,) = deadband.verdict.effects
    assert effect.name == "motor_deadband"
    width = effect.parameters["offset"]
    assert abs(width.value - 0.04) < 4.0 * width.sd


def test_named_effect_removes_the_error_on_a_new_drive(deadband):
    holdout = deadband.verdict.holdout
    assert holdout.before.xy_m > 1.3 * holdout.after.xy_m
    assert holdout.after.xy_m < 1.25 * holdout.floor.xy_m


def test_verdict_is_plain_json(deadband):
    plain = json.loads(json.dumps(deadband.verdict.as_json(), allow_nan=False))
    assert plain["verdict"] == "explained"
    assert plain["fit"]["horizon_s"] == 2.0
    assert all(rival["evidence_gap"] > 0.0 for rival in plain["rivals"])
    assert 0.2 < plain["effects"][0]["share"] <= 1.0
    assert plain["effects"][0]["closure"] == "both alike"
    assert plain["effects"][0]["phenomenon"]


@pytest.fixture(scope="module")
def pushed_twice():
    """A robot that something pushed once in each of its drives, at other moments."""
    pushes = {"external_push__impulse_turn": 0.06}
    drives = [recording(seed, external_push__start=start, **pushes) for seed, start in ((0, 15.2), (1, 22.6))]
    others = tuple(name for name in registry() if name not in (*SMALL, "external_push"))
    return diagnose(drives, without=others)


def test_a_push_in_every_recording_is_named_with_the_moment_of_each(pushed_twice):
    (effect,) = pushed_twice.verdict.effects
    assert effect.name == "external_push"
    starts = sorted(e.value for name, e in effect.parameters.items() if name.startswith("start"))
    assert starts == pytest.approx([15.2, 22.6], abs=0.3)


def test_its_sentence_tells_each_recordings_push(pushed_twice):
    text = pushed_twice.verdict.effects[0].sentence
    assert text.startswith("In every drive something pushed the robot by (")
    assert "at 15.2 ± 0.06 s in recording 1, at 22.6 ± 0.0" in text


def test_pushes_of_their_own_are_told_recording_by_recording():
    push = registry()["external_push"].closure("push")
    ranked = Ranked(Hypothesis("external_push", push.frees, 0, closure="push"), None, 0.0, 0.0)
    numbers = {
        f"{name}{tail}": Estimate(value, 0.1, registry()["external_push"].parameter(name).unit)
        for tail, begin in (("", 15.2), ("_2", 22.6))
        for name, value in (("start", begin), ("impulse_x", 1.0), ("impulse_y", 0.0))
    }
    text = _sentences(ranked, numbers, SimpleNamespace(runs_of=lambda name: (0, 1)))
    assert "Recording 1: At 15.2" in text
    assert "Recording 2: At 22.6" in text


def test_a_kick_that_no_regime_shows_is_found_beside_what_every_regime_shows():
    kick = {"external_push__impulse_turn": 0.018, "external_push__start": 21.0}
    decision = judged(["coulomb_friction", "external_push"], coulomb_friction__friction=0.006, **kick)
    assert {belief.name for belief in decision.named} == {"coulomb_friction", "external_push"}


def test_a_clock_whose_rate_changes_is_told_from_one_that_is_off_by_as_much_all_the_time():
    drifting = {"clock_drift__drift": 0.001, "clock_drift__change": 2e-4}
    [belief] = judged(["clock_drift", "observation_delay"], **drifting).named
    assert belief.effect.hypothesis.closure == "changing rate"
    place = parameter_table().place("clock_drift.change")
    [(change, variance)] = [(x, v) for slot, x, v in belief.effect.fit.numbers() if slot.place == place]
    assert change == pytest.approx(2e-4, abs=3 * variance**0.5)


def test_a_plain_robot_is_a_match():
    assert judged(SMALL).outcome == "match"


def test_a_match_says_what_would_have_been_seen():
    verdict = diagnose([recording(seed) for seed in (0, 1)], without=OTHERS).verdict
    text = "\n".join(summary_lines(verdict.as_json()))
    size = verdict.smallest_seen["motor_deadband.offset"].value
    assert f"motor_deadband.offset {size:.2g}" in text


def test_the_true_effect_taken_out_is_not_replaced_by_a_neighbour():
    decision = judged(("command_delay", "floor_tilt"), motor_deadband__offset=0.05)
    assert decision.outcome == "unexplained"
    assert not decision.reason.startswith("detected")


def test_no_fit_is_worse_than_its_parent():
    decision = judged(SMALL, motor_deadband__offset=0.04)
    assert all(ranked.gain >= -1e-6 for ranked in decision.ranking)


def test_two_delays_are_one_set_without_encoders():
    decision = judged(("command_delay", "observation_delay", "floor_tilt"), command_delay__delay=0.06)
    first, second, *_ = decision.ranking
    assert {first.name, second.name} == {"command_delay", "observation_delay"}
    assert set(decision.named[0].among) == {first.name, second.name}


def test_nothing_left_is_adequate_whatever_the_gain():
    class Test:
        surprise, gain, group = 1.0, 50.0, type("Group", (), {"name": "turn:time"})

    assert adequacy([Test()], 10.0).left == 0.0


def test_areas_climb_to_the_most_promising_place():
    def judge(areas):
        return np.array([1.0 - np.hypot(a.x - 0.31, a.y + 0.12) - abs(a.half_x - 0.2) for a in areas])

    best, gain = settled(Area(0.2, 0.0, 0.25, 0.25), judge)
    assert np.hypot(best.x - 0.31, best.y + 0.12) < 0.02
    assert gain > 0.95


def test_kept_candidates_lie_apart():
    centres = np.array([[0.0, 0.0], [0.05, 0.0], [0.5, 0.0]])
    assert apart(np.array([2.0, 3.0, 1.0]), centres, keep=3, distance=0.2) == [1, 2]


@pytest.mark.parametrize(("second", "said"), [(0.53, 1), (0.61, 2)])
def test_a_second_name_below_the_gate_is_not_said(second, said):
    beliefs = tuple(SimpleNamespace(probability=p) for p in (0.95, second))
    model = Model((), None, None, (), None, beliefs=beliefs)
    assert model.named(DEFAULT_GATES.least_confidence) == beliefs[:said]


def test_forces_carry_the_doubt_of_the_mass():
    friction = registry()["coulomb_friction"]
    assert with_doubt(friction, "friction", 0.01, 1e-12) == pytest.approx(0.002, rel=1e-3)


def test_a_slippery_spot_carries_the_doubt_of_a_slide_in_its_place():
    assert with_doubt(registry()["low_friction_patch"], "x", 0.1, 1e-12) == pytest.approx(0.06, rel=1e-3)
    assert with_doubt(registry()["misplaced_marker"], "x", 0.1, 1e-12) == pytest.approx(0.015, rel=1e-3)


@pytest.mark.parametrize(
    ("effect", "parameter", "doubt"),
    [
        ("external_push", "start", 0.05),
        ("rough_floor_patch", "half_x", 0.015),
        ("caster_drag", "arm", 0.0),
        ("rough_floor_patch", "spread", 0.0),
        ("battery_sag", "relaxation", 0.0),
    ],
)
def test_doubt_of_a_frame_or_of_half_a_tyre_belongs_to_moments_and_places_alone(effect, parameter, doubt):
    assert model_spread(registry()[effect], parameter, 0.1) == doubt


def test_a_number_that_the_data_cannot_tell_has_no_interval():
    assert np.isnan(with_doubt(registry()["command_delay"], "delay", 0.1, 0.0))


def test_a_name_that_cannot_be_told_from_another_is_as_sure_as_both_together():
    delays = ("command_delay", "observation_delay")
    trains = [recording(seed, command_delay__delay=0.1) for seed in (0, 1)]
    verdict = diagnose(trains, without=tuple(set(registry()) - set(delays))).verdict
    assert set(verdict.ambiguous[0]) == set(delays)
    assert verdict.effects[0].confidence > 0.9
    lines = summary_lines(verdict.as_json())
    assert any(
        "command_delay or observation_delay" in x or "observation_delay or command_delay" in x for x in lines
    )
