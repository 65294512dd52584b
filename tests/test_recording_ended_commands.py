"""A command log that ends before the drive does: known by a robot that goes on to do several things."""

import dataclasses

import numpy as np
import pytest

from fsm_calib.recording.channels import CommandTrack, PoseTrack, TwistTrack
from fsm_calib.recording.ended_commands import without_unlogged_commands
from fsm_calib.recording.recording import Recording
from fsm_calib.recording.unknown_commands import unknown_spans

BEFORE = [(-8.0 + k, 0.3, (-1.0) ** k) for k in range(8)]
PLAN = [
    *BEFORE, (0.0, 0.3, 0.0), (2.0, 0.2, 1.0), (4.0, 0.0, 0.0), (5.0, 0.3, -0.5), (7.0, 0.3, 0.0), (8.5, 0.0, 1.5),
]  # fmt: skip


def driven(plan=PLAN, until=10.0, noise=0.003, logged=None, seed=0):
    """Return the poses of a robot that follows (begin [s], v, omega) and the first `logged` of its commands."""
    time = np.arange(plan[0][0], until, 0.05)
    begins, v, omega = np.array(plan).T
    row = np.searchsorted(begins, time, side="right") - 1
    theta = np.cumsum(omega[row]) * 0.05
    x, y = np.cumsum(v[row] * np.cos(theta)) * 0.05, np.cumsum(v[row] * np.sin(theta)) * 0.05
    off = noise * np.random.default_rng(seed).normal(size=(3, len(time)))
    some = slice(0, logged)
    left, right = 2.0 * (v - 0.05 * omega), 2.0 * (v + 0.05 * omega)
    return Recording(
        pose=PoseTrack(time, x + off[0], y + off[1], theta + 3.0 * off[2]),
        command=CommandTrack(begins[some], left[some], right[some]),
    )


def kinds(recording):
    return [finding.kind for finding in recording.checks]


def test_commands_end_with_the_last_where_the_robot_goes_on_to_do_several_things():
    recording = without_unlogged_commands(driven(logged=12))
    assert kinds(recording) == ["ended"]
    assert recording.command.ended.tolist() == 11 * [0.0] + [1.0]
    assert "the last is of 5.00 s" in recording.checks[0].sentence
    assert recording.checks[0].time == 5.0


def test_what_the_robot_did_after_the_end_is_unknown():
    recording = without_unlogged_commands(driven(logged=12))
    assert unknown_spans(recording.command).tolist() == [[5.0, np.inf]]


def test_twists_end_as_commands_do():
    recording = driven(logged=12)
    twist = TwistTrack(recording.command.time, recording.command.left, recording.command.right)
    recording = without_unlogged_commands(dataclasses.replace(recording, command=None, twist=twist))
    assert unknown_spans(recording.twist).tolist() == [[5.0, np.inf]]


def test_the_end_stays_with_its_command_where_the_clock_is_moved_or_rows_are_taken():
    track = without_unlogged_commands(driven(logged=12)).command
    later = dataclasses.replace(track, time=track.time + 100.0)
    assert unknown_spans(later).tolist() == [[105.0, np.inf]]
    assert unknown_spans(track.rows(slice(0, 8))).tolist() == []


@pytest.mark.parametrize(
    ("recording", "why"),
    [
        (driven(), "every command was logged"),
        (driven(PLAN[:13], until=20.0), "the last is a straight of 13 s"),
        (driven([*PLAN[:11], (5.0, 0.3, 0.9)], until=20.0), "the last is a circle of 15 s"),
        (driven(PLAN[:11], until=20.0), "the last is a rest of 16 s"),
        (driven([*PLAN[:11], (5.0, 0.3, 0.9)], until=20.0, noise=0.03), "a circle under a poor tracker"),
        (driven(PLAN[4:], logged=8), "seven pauses are too few to know a usual one"),
        (driven(logged=13, until=9.8), "the last may have held as long as another"),
    ],
)
def test_a_last_command_that_may_have_held_stays(recording, why):
    assert kinds(without_unlogged_commands(recording)) == [], why


def test_a_robot_whose_headings_nobody_measured_shows_it_by_its_speed():
    recording = driven(logged=12)
    recording = dataclasses.replace(
        recording, pose=dataclasses.replace(recording.pose, theta=np.full(len(recording.pose), np.nan))
    )
    assert kinds(without_unlogged_commands(recording)) == ["ended"]


def test_commands_that_say_when_they_are_stale_are_believed():
    recording = driven(logged=12)
    command = dataclasses.replace(recording.command, stale_after=1.0)
    assert kinds(without_unlogged_commands(dataclasses.replace(recording, command=command))) == []
