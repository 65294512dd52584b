"""Rows that repeat what a slow sensor said before: known by their digits and how long they last, and dropped."""

import numpy as np
import pytest

from fsm_calib.recording.channels import PoseTrack, WheelPair
from fsm_calib.recording.held_rows import held_rows, without_held_rows
from fsm_calib.recording.recording import Recording, RobotFacts

FINE = np.arange(0.0, 40.0, 0.05)
"""A log at 20 Hz."""


def sampled(rate, digits=6, seed=2):
    """Return numbers (n, 2) with noise that a sensor brings `rate` times a second, held on the fine grid."""
    rng = np.random.default_rng(seed)
    numbers = np.round(rng.normal(3.0, 1.0, (int(40.0 * rate) + 2, 2)), digits)
    return numbers[np.floor(FINE * rate + 1e-9).astype(int)]


def test_a_log_on_a_finer_grid_than_its_sensor_is_thinned_to_what_was_measured():
    numbers = sampled(4.0)
    kept = ~held_rows(FINE, numbers)
    assert np.diff(FINE[kept]) == pytest.approx(0.25)
    assert len(np.unique(numbers[kept], axis=0)) == kept.sum()


@pytest.mark.parametrize(
    ("numbers", "why"),
    [
        (sampled(20.0), "every row is new"),
        (sampled(0.5), "a set-point holds for seconds"),
        (sampled(4.0, digits=0), "few digits repeat by themselves"),
        (np.zeros((len(FINE), 2)), "wheels at rest have no noise"),
    ],
)
def test_other_repeats_stay(numbers, why):
    assert not held_rows(FINE, numbers).any(), why


def test_a_rest_on_a_tracker_without_noise_stays_as_it_is():
    path = np.column_stack([np.where(FINE < 20.0, FINE, 20.0), 0.1 * np.sin(FINE)])
    path[FINE >= 20.0] = path[FINE >= 20.0][0]
    assert not held_rows(FINE, path).any()


def test_within_a_slow_sensors_log_a_long_rest_stays():
    numbers = sampled(4.0)
    numbers[(FINE >= 10.0) & (FINE < 12.0)] = 3.25
    held = held_rows(FINE, numbers)
    resting = (FINE > 10.0) & (FINE < 12.0)
    assert held[~resting].mean() > 0.7
    assert not held[resting].any()


@pytest.mark.parametrize(("speed", "is_dropped"), [(2.0, True), (0.0, False)])
def test_a_pose_that_is_held_for_longer_is_dropped_where_the_wheels_turn_all_the_while(speed, is_dropped):
    pose, lost = sampled(4.0), (FINE >= 10.0) & (FINE < 12.0)
    pose[lost] = 3.25
    rate = np.where(lost, speed, 3.0)
    recording = Recording(
        robot=RobotFacts(name="lost"),
        pose=PoseTrack(FINE, *pose.T, np.zeros(len(FINE))),
        wheel_rate=WheelPair(FINE, rate, rate),
    )
    kept = without_held_rows(recording).pose.time
    assert ((kept > 10.0) & (kept < 12.0)).any() != is_dropped


def test_what_was_dropped_is_told():
    pose, rate = sampled(4.0), sampled(20.0)
    recording = Recording(
        robot=RobotFacts(name="slow"),
        pose=PoseTrack(FINE, *pose.T, np.zeros(len(FINE))),
        wheel_rate=WheelPair(FINE, *rate.T),
    )
    thinned = without_held_rows(recording)
    [finding] = thinned.checks
    assert (finding.channel, finding.kind, finding.action) == ("pose", "held", "dropped")
    assert finding.rows == len(FINE) - len(thinned.pose)
    assert "about 4.0 numbers a second" in finding.sentence
    assert len(thinned.wheel_rate) == len(FINE)


def test_a_recording_without_repeats_is_the_same_object():
    recording = Recording(robot=RobotFacts(name="quick"), wheel_rate=WheelPair(FINE, *sampled(20.0).T))
    assert without_held_rows(recording) is recording
