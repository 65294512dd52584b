"""A match holds on the hold-out in its tail, in blocks: one stretch that is not predicted refutes it, and is told."""

from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis_robots import recording

from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.diagnosis.proof.holds import BLOCK, FEWEST, breach_of
from fsm_calib.diagnosis.proof.windows import Windows
from fsm_calib.world2d.effects import registry

CONSIDERED = "command_delay"
WITHOUT = [name for name in registry() if name != CONSIDERED]
CORNER = {"x": 0.6, "y": -1.2, "half_x": 0.4, "half_y": 0.3, "drag": 1.0}
PATCH = {f"rough_floor_patch__{name}": value for name, value in CORNER.items()}


@pytest.fixture(scope="module")
def train():
    """Drives that never come near the corner."""
    return [recording(seed) for seed in (0, 1)]


def test_a_match_that_the_hold_out_contradicts_in_one_corner_is_none(train):
    verdict = diagnose(train, [recording(2, **PATCH)], without=WITHOUT).verdict
    assert verdict.verdict == "unexplained"
    assert "but for one stretch: drive-2" in verdict.reason
    assert "fit that recording, too" in verdict.reason
    where = verdict.located.where
    assert abs(where["x"] - CORNER["x"]) < CORNER["half_x"] + where["radius"]
    assert abs(where["y"] - CORNER["y"]) < CORNER["half_y"] + where["radius"]
    assert verdict.located.when


def test_a_hold_out_of_the_same_robot_confirms_the_match(train):
    assert diagnose(train, [recording(2)], without=WITHOUT).verdict.verdict == "match"


def test_a_name_that_makes_the_held_out_prediction_worse_is_none():
    without = [name for name in registry() if name != "motor_deadband"]
    late = {"motor_deadband__offset": 0.06}
    cured = diagnose([recording(s, **late) for s in (0, 1)], [recording(2, **late)], without=without).verdict
    worse = diagnose([recording(s, **late) for s in (0, 1)], [recording(2)], without=without)
    assert [e.name for e in cured.effects] == ["motor_deadband"]
    assert (worse.verdict.verdict, worse.verdict.effects) == ("unexplained", ())
    assert (
        "motor_deadband would be named, but with it the errors on the held-out recordings rise"
        in worse.verdict.reason
    )
    assert worse.holdout.after == worse.holdout.before


def test_errors_that_stay_far_above_the_noise_beside_a_name_are_told():
    without = [name for name in registry() if name != "motor_deadband"]
    dead, leaning = {"motor_deadband__offset": 0.06}, {"floor_tilt__slope_x": 0.03}
    fitted = [recording(s, **dead) for s in (0, 1)]
    all_of_it = diagnose(fitted, [recording(2, **dead)], without=without).verdict
    a_part = diagnose(fitted, [recording(2, **dead, **leaning)], without=without).verdict
    assert [e.name for e in a_part.effects] == ["motor_deadband"]
    assert "more is missing" in a_part.reason
    assert "more is missing" not in all_of_it.reason


def windows(rng, seconds=60.0, worse=None, by=6.0):
    """Return windows whose errors are those of the noise, `by` times as large from `worse` [s] for one block."""
    time = np.arange(0.0, seconds, 0.25)
    error = rng.normal(size=(len(time), 3)) * [0.002, 0.002, 0.01]
    floor = np.tile([0.002 * np.sqrt(2.0 * np.log(2.0)), 0.01 * 0.67449], (len(time), 1))
    if worse is not None:
        error[(time >= worse) & (time < worse + BLOCK)] *= by
    return Windows(time, error, floor)


def simulator(seconds=60.0):
    """Return what is asked of a simulator: where the robot was, here on a line at 0.1 m/s."""
    time = np.arange(0.0, seconds, 0.1)
    reference = np.column_stack([0.1 * time, np.zeros_like(time), np.zeros_like(time)])
    return SimpleNamespace(prepared=SimpleNamespace(time=time, reference=reference))


def test_one_bad_block_among_many_good_ones_is_found_though_no_median_shows_it():
    rng = np.random.default_rng(0)
    both = [windows(rng), windows(rng, worse=20.0)]
    size = np.hypot(*np.vstack([w.error for w in both]).T[:2])
    assert np.median(size) < 1.1 * both[0].floor[0, 0]
    found = breach_of(both, [simulator(), simulator()])
    assert (found.recording, found.start, found.end) == (1, 20.0, 20.0 + BLOCK)
    assert found.x == pytest.approx(2.1, abs=0.01)
    assert found.ratio > 3.0


def test_noise_alone_breaches_in_fewer_than_one_in_a_hundred_robots():
    rng = np.random.default_rng(1)
    assert sum(breach_of([windows(rng)], [simulator()]) is not None for _ in range(300)) <= 2


def test_one_bad_frame_is_no_breach():
    good = windows(np.random.default_rng(2))
    good.error[80] *= 20.0
    assert breach_of([good], [simulator()]) is None


def test_too_few_windows_are_no_block():
    few = windows(np.random.default_rng(3), worse=0.0, by=50.0)
    some = slice(0, FEWEST - 1)
    assert breach_of([Windows(few.time[some], few.error[some], few.floor[some])], [simulator()]) is None
