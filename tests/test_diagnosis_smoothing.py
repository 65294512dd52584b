"""Which poses are lone spikes: one frame that leaves its neighbours' chord, headings modulo whole turns."""

import numpy as np
import pytest

from fsm_calib.diagnosis.replay.smoothing import lone_spikes

TIME = 0.05 * np.arange(60)
THETA = 0.8 * TIME + np.random.default_rng(1).normal(0.0, 0.004, len(TIME))


def flipped(*rows):
    theta = THETA.copy()
    theta[list(rows)] += np.pi
    return np.unwrap(theta)


@pytest.mark.parametrize("rows", [(20,), (12, 31, 50)], ids=["one", "several"])
def test_a_heading_that_is_half_round_for_a_frame_is_a_spike(rows):
    assert np.flatnonzero(lone_spikes(TIME, flipped(*rows), turning=True)).tolist() == list(rows)


def test_a_heading_is_no_spike_because_another_was_counted_a_whole_turn_further():
    theta = THETA + 2.0 * np.pi * (TIME > 1.0)
    assert not lone_spikes(TIME, theta, turning=True).any()


def test_a_step_of_the_heading_stays():
    assert not lone_spikes(TIME, THETA + 0.5 * (TIME > 1.0), turning=True).any()


def test_a_place_that_is_off_for_a_frame_is_a_spike():
    x = THETA.copy()
    x[25] += 0.3
    assert np.flatnonzero(lone_spikes(TIME, x)).tolist() == [25]
