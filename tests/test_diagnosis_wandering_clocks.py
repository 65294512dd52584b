"""Wheels whose clock wanders beside the poses' are laid on theirs; delays, drifts and sticking treads are left."""

from dataclasses import replace

import numpy as np
import pytest
from sticking_treads import turned

from fsm_calib.diagnosis.intake import take_in
from fsm_calib.diagnosis.wandering_clocks import wandering, with_steady_clocks
from fsm_calib.recording.channels import CommandTrack, PoseTrack, WheelPair
from fsm_calib.recording.recording import Recording, RobotFacts

AXLE, LASTS = 0.5, 160.0  # m, s


def drive(lag, twist=0.0, seed=0):
    """Return wheels and poses of a robot that turns left and right; the wheels' stamps are early by lag(t) [s]."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, LASTS, 0.02)
    edges = np.arange(0.0, LASTS, 2.0)
    half = rng.uniform(-0.1, 0.1, edges.size)[np.searchsorted(edges, time, side="right") - 1]
    theta = turned(2.0 * half[:-1] * 0.02 / AXLE, twist)
    way = 0.3 * 0.02
    x, y = np.cumsum(way * np.cos(theta)), np.cumsum(way * np.sin(theta))
    noise = 1e-3 * rng.normal(size=(3, time.size))
    rows, seen = slice(5, -5, 5), slice(0, None, 3)
    stamps = time[rows] - lag(time[rows])
    return Recording(
        robot=RobotFacts("counted", wheel_radius=0.1, axle_length=AXLE),
        wheel_speed=WheelPair(stamps, 0.3 - half[rows], 0.3 + half[rows], "m/s"),
        pose=PoseTrack(time[seen], *(p[seen] + n[seen] for p, n in zip((x, y, theta), noise, strict=True))),
    )


def bumps(t):
    """Return a lag [s] that rises to 0.8 s and falls back, twice."""
    return 0.4 - 0.4 * np.cos(4.0 * np.pi * t / LASTS)


def off(recording):
    """Return how far the walk that is found lies from `bumps` [s], root mean square."""
    walk, time = wandering(recording.wheel_speed, recording.pose), np.arange(10.0, 150.0)
    return np.sqrt(np.mean((np.interp(time, walk.time, walk.lag) - bumps(time)) ** 2))


def test_a_clock_that_wanders_is_found_to_a_grid_step():
    assert off(drive(bumps)) < 0.1


def test_wheels_of_such_a_clock_are_laid_on_the_poses_clock_and_it_is_told():
    (laid,), (said,) = with_steady_clocks([drive(bumps)])
    true = drive(lambda t: 0.0 * t).wheel_speed.time
    assert np.sqrt(np.mean((laid.wheel_speed.time - true) ** 2)) < 0.1
    assert (np.diff(laid.wheel_speed.time) > 0.0).all()
    assert "the wheels' clock wanders by 0.8" in said
    assert any("clock wanders" in note for note in take_in([drive(bumps)]).notes)


@pytest.mark.parametrize(
    "lag",
    [
        lambda t: 0.0 * t,
        lambda t: 0.4 + 0.0 * t,
        lambda t: 0.004 * t - 0.3,
        lambda t: 0.8 * (t / LASTS) ** 2,
    ],
    ids=["none", "a delay", "a drifting clock", "a clock whose rate changes"],
)
def test_lags_that_have_a_name_are_left(lag):
    recording = drive(lag)
    assert with_steady_clocks([recording]) == ([recording], [])


def test_treads_that_stick_are_no_wandering_clock():
    recording = drive(lambda t: 0.0 * t, twist=0.04)
    assert with_steady_clocks([recording]) == ([recording], [])


def test_beside_treads_that_stick_the_clock_is_found():
    assert off(drive(bumps, twist=0.04)) < 0.15


def test_wheels_that_only_measure_beside_commands_keep_their_clock():
    commanded = replace(
        drive(bumps), command=CommandTrack(np.array([0.0, 1.0]), np.array([0.1, 0.2]), np.array([0.1, 0.2]))
    )
    assert with_steady_clocks([commanded]) == ([commanded], [])
