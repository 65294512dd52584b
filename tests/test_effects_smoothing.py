"""A tracker that smooths: the filter against its known answers, in the world, in replays and in a diagnosis."""

from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis_robots import judged, recording

from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.replay.prepared import prepare
from fsm_calib.diagnosis.replay.simulator import make_simulator, nominal_values
from fsm_calib.world2d.effects.observation_delay import filtered
from fsm_calib.world2d.overhead import OverheadTracker, TrackerSettings
from fsm_calib.world2d.parameters import parameter_table, parameters

TAU = 0.12
LATE = {"observation_delay.delay": TAU, "observation_delay.smoothing": TAU}
"""A filter and nothing else: all of the delay is its own."""


NOMINAL = 0.0318 * 20.0
"""Rim speed of command 1 [m/s]."""


def numbers(smoothing: float, apart: float = 0.0) -> np.ndarray:
    return np.array([0.0, smoothing, apart])


def test_a_step_is_answered_exponentially():
    times = np.sort(np.random.default_rng(2).uniform(0.0, 1.0, 200))
    poses = np.ones((200, 3))
    poses[0] = 0.0
    poses[1] = 1.0
    after = filtered(numbers(TAU), times, poses)
    first = after[1]
    expected = 1.0 - (1.0 - first) * np.exp(-(times[1:, None] - times[1]) / TAU)
    assert after[1:] == pytest.approx(expected, abs=1e-12)


def test_steady_motion_is_held_back_by_the_time_constant():
    times = np.arange(0.0, 3.0, 0.03)
    path = np.outer(times, [0.3, -0.1, 2.0])
    after = filtered(numbers(TAU), times, path)
    assert after[-1] == pytest.approx(path[-1] - TAU * np.array([0.3, -0.1, 2.0]), abs=1e-9)


def test_headings_behind_a_faster_filter_are_held_back_by_less():
    times = np.arange(0.0, 3.0, 0.03)
    path = np.outer(times, [0.3, -0.1, 2.0])
    after = filtered(numbers(TAU, 0.05), times, path)
    assert after[-1, :2] == pytest.approx(path[-1, :2] - TAU * np.array([0.3, -0.1]), abs=1e-9)
    assert after[-1, 2] == pytest.approx(path[-1, 2] - (TAU - 0.05) * 2.0, abs=1e-9)


@pytest.mark.parametrize(
    ("smoothing", "apart", "earlier"), [(0.0, 0.05, 0.05), (0.0, -0.05, -0.05), (0.04, 0.1, 0.06)]
)
def test_headings_without_a_filter_are_shifted_in_time(smoothing: float, apart: float, earlier: float):
    times = np.arange(0.0, 3.0, 0.01)
    path = np.column_stack([times, times, np.sin(times)])
    after = filtered(numbers(smoothing, apart), times, path)
    inside = (times > 0.2) & (times < 2.8)
    assert after[inside, 2] == pytest.approx(np.sin(times + earlier)[inside], abs=1e-4)


def test_headings_as_late_as_places_pass_the_same_filter():
    times, path = np.arange(20.0), np.random.default_rng(4).normal(size=(20, 3))
    apart = filtered(numbers(2.0, 1e-12), times, path)
    assert apart == pytest.approx(filtered(numbers(2.0), times, path), abs=1e-9)


def test_no_time_constant_leaves_poses_as_they_are():
    path = np.random.default_rng(3).normal(size=(20, 3))
    assert filtered(numbers(0.0), np.arange(20.0), path) is path


def test_a_replay_sees_through_the_filter_what_a_prediction_does():
    driven = recording(4, noise=0.0, gain_left=NOMINAL, gain_right=NOMINAL, **LATE)
    simulator = make_simulator(prepare(driven))
    values = np.tile(nominal_values([simulator]), (2, 1))
    values[1] = with_values(values[1:], LATE)[0]
    plain, smooth = (found - simulator.prepared.step for found in simulator.increments(values))
    assert np.abs(smooth[:, :3]).max() < 0.05 * np.abs(plain[:, :3]).max()


class Moving:
    """A world whose robot speeds up, of which the first `until` seconds are past."""

    def __init__(self) -> None:
        self.until = 0.0
        self.spec = SimpleNamespace(seed=3)

    @property
    def truth(self) -> SimpleNamespace:
        times = np.arange(0.0, self.until, 0.002)
        trace = np.column_stack([times, 0.1 * times**2, np.sin(times), 0.3 * times])
        return SimpleNamespace(trace=trace, parameters=parameters(LATE))


def seen_by_tracker(at: list[float]) -> np.ndarray:
    world = Moving()
    tracker = OverheadTracker(world, TrackerSettings(15.0, 0.0, 0.0, 0.0))
    found = []
    for world.until in at:
        found += tracker.poses()
    return np.array(found)


def test_a_tracker_asked_often_sees_what_one_asked_once_does():
    often, once = seen_by_tracker([2.0, 7.3, 15.0, 21.0, 40.0]), seen_by_tracker([40.0])
    assert often == pytest.approx(once, abs=1e-9)


def test_a_tracker_that_smooths_lags_behind_what_speeds_up():
    t, x = seen_by_tracker([10.0])[-1, :2]
    assert x == pytest.approx(0.1 * (t**2 - 2.0 * TAU * t + 2.0 * TAU**2), abs=1e-5)


def test_a_filter_is_told_from_a_delay():
    [belief] = judged(["command_delay", "observation_delay"], **LATE).named
    assert (belief.name, belief.effect.hypothesis.closure) == ("observation_delay", "smoothed")
    place = parameter_table().place("observation_delay.smoothing")
    [(found, variance)] = [(x, v) for slot, x, v in belief.effect.fit.numbers() if slot.place == place]
    assert found == pytest.approx(TAU, abs=3.0 * variance**0.5)


def test_places_behind_a_slower_filter_than_headings_are_told():
    hidden = {**LATE, "observation_delay.apart": 0.07}
    [belief] = judged(["command_delay", "observation_delay"], **hidden).named
    assert (belief.name, belief.effect.hypothesis.closure) == ("observation_delay", "smoothed apart")
    place = parameter_table().place("observation_delay.apart")
    [(found, variance)] = [(x, v) for slot, x, v in belief.effect.fit.numbers() if slot.place == place]
    assert found == pytest.approx(0.07, abs=3.0 * variance**0.5)
