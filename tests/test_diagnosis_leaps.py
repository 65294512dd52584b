"""Where a tracker finds the robot elsewhere no motion is fitted, and the path begins anew."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_robots import recording

from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.diagnosis.replay.prepared import prepare
from fsm_calib.recording.leaps import leaps

LEAP = 20.0  # s
TURN, SHIFT = 1.2, 2.0  # rad, m


def found_elsewhere(seen):
    """Return the drive with its map turned and shifted from `LEAP` on."""
    pose, late = seen.pose, seen.pose.time > LEAP
    z = (pose.x + 1j * pose.y) * np.exp(1j * TURN) + SHIFT
    return replace(
        seen,
        pose=replace(
            pose,
            x=np.where(late, z.real, pose.x),
            y=np.where(late, z.imag, pose.y),
            theta=pose.theta + TURN * late,
        ),
    )


def test_the_pose_after_a_leap_is_known_by_its_speed():
    pose = found_elsewhere(recording(0)).pose
    mask = leaps(pose.time, pose.x, pose.y, pose.theta, 3.0)
    assert np.flatnonzero(mask).tolist() == [int(np.searchsorted(pose.time, LEAP, side="right"))]


def test_a_heading_that_leaps_alone_is_known_and_whole_turns_are_none():
    pose = recording(0).pose
    late = pose.time > LEAP
    assert leaps(pose.time, pose.x, pose.y, pose.theta + 2.0 * np.pi * late, 3.0).sum() == 0
    assert leaps(pose.time, pose.x, pose.y, pose.theta + 1.5 * late, 3.0).sum() == 1


def test_nothing_is_scored_across_a_leap():
    before, after = prepare(recording(0)), prepare(found_elsewhere(recording(0)))
    assert after.innovations == before.innovations - 3


def test_the_smoothed_path_follows_the_poses_on_both_sides_of_a_leap():
    laid = prepare(found_elsewhere(recording(0)))
    off = np.hypot(laid.reference[:, 0] - laid.poses.x, laid.reference[:, 1] - laid.poses.y)
    assert off.max() < 0.01


def test_a_column_that_leaps_all_the_time_is_left_to_the_likelihood():
    seen = recording(0)
    x = seen.pose.x + 0.5 * (np.arange(len(seen.pose)) // 4 % 2) * (seen.pose.time > 2.0)
    laid = prepare(replace(seen, pose=replace(seen.pose, x=x)))
    assert laid.restart.sum() == 1


def test_a_robot_whose_map_moved_in_each_drive_matches():
    found = diagnose([found_elsewhere(recording(seed)) for seed in (0, 1)])
    assert found.decision.outcome == "match"
    assert found.decision.base.values == pytest.approx(
        diagnose([recording(seed) for seed in (0, 1)]).decision.base.values, rel=0.05, abs=0.02
    )
