"""Poses that are repeated while the tracker has lost the robot: known by the leap after them, and dropped."""

import numpy as np
import pytest

from fsm_calib.recording.channels import CommandTrack, PoseTrack, WheelPair
from fsm_calib.recording.lost_tracker import lost_rows, without_lost_poses
from fsm_calib.recording.recording import Recording, RobotFacts

TIME = np.arange(0.0, 20.0, 1.0 / 30.0)
GOING = np.ones(len(TIME), dtype=bool)
LOST = (TIME > 8.0) & (TIME < 8.6)


def path(speed=0.3, turn=0.5, noise=0.0):
    """Return the poses (n, 3) of a robot on a circle, one that is told to start after two seconds."""
    driven = np.maximum(TIME - 2.0, 0.0)
    theta = turn * driven
    poses = np.column_stack([np.sin(theta) * speed / turn, (1.0 - np.cos(theta)) * speed / turn, theta])
    poses[:, 2] = np.angle(np.exp(1j * poses[:, 2]))
    return poses + noise * np.random.default_rng(0).normal(size=poses.shape)


def held(poses, rows):
    """Return poses of which some rows repeat the last one before them."""
    return np.where(rows[:, None], poses[np.argmax(rows) - 1], poses)


@pytest.mark.parametrize("noise", [0.0, 0.002])
def test_repeats_before_a_leap_of_a_robot_under_way_are_lost(noise):
    assert (lost_rows(held(path(noise=noise), LOST), GOING) == LOST).all()


@pytest.mark.parametrize("rows", [LOST, (TIME > 14.5) & (TIME < 15.0)])  # the second where headings turn over
def test_a_pose_without_repeats_is_kept_wherever(rows):
    assert not lost_rows(path(noise=0.002), GOING).any()
    assert not lost_rows(held(path(), rows), ~GOING).any()


def test_a_robot_that_rests_leaves_its_place_slowly():
    poses = path()
    slow = np.clip((TIME - 2.0) / 0.5, 0.0, 1.0)[:, None] * (poses - poses[0]) + poses[0]
    assert not lost_rows(slow, GOING).any()


def test_a_tracker_that_drops_every_other_frame_has_not_lost_the_robot():
    poses = path(noise=0.002)
    assert not lost_rows(poses[np.arange(len(poses)) // 2 * 2], GOING).any()


def recorded(**channels):
    x, y, theta = held(path(noise=0.002), LOST).T
    return Recording(robot=RobotFacts(name="lost"), pose=PoseTrack(TIME, x, y, theta), **channels)


def test_what_was_lost_is_dropped_and_told():
    wheels = WheelPair(TIME, np.full(len(TIME), 5.0), np.full(len(TIME), 6.0))
    kept = without_lost_poses(recorded(wheel_rate=wheels))
    [finding] = kept.checks
    assert (finding.channel, finding.kind, finding.action, finding.rows) == (
        "pose",
        "lost",
        "dropped",
        LOST.sum(),
    )
    assert "the tracker had lost it" in finding.sentence
    assert len(kept.pose) == len(TIME) - LOST.sum()


def test_commands_tell_that_it_drives_where_no_wheels_are_measured():
    def told(command):
        steps = CommandTrack(np.array([0.0, 2.0, 7.5, 19.9]), *np.tile([0.0, 0.5, command, 0.0], (2, 1)))
        return recorded(command=steps)

    assert len(without_lost_poses(told(0.5)).pose) == len(TIME) - LOST.sum()
    resting = told(0.0)
    assert without_lost_poses(resting) is resting


def test_without_wheels_and_commands_nothing_is_dropped():
    recording = recorded()
    assert without_lost_poses(recording) is recording
