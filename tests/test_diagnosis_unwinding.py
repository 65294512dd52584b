"""Headings over gaps: how often the robot turned round is read from its wheels."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_robots import recording

from fsm_calib.diagnosis.replay.heading_unwrap import unwound
from fsm_calib.recording.channels import CommandTrack, PoseTrack, TwistTrack

RATE = 4.0  # rad/s


def spin(gap, side=1.0, scale=9.0):
    """A robot that starts to spin at 5 s, seen at 20 Hz but for `gap` seconds at 12 s; true and logged headings."""
    time = np.arange(0.0, 20.0, 0.05)
    time = time[(time <= 12.0) | (time > 12.0 + gap)]
    theta = side * RATE * np.clip(time - 5.15, 0.0, None)
    wheel = 0.5 * side * RATE / scale
    drive = replace(
        recording(0),
        command=CommandTrack(np.array([0.0, 5.0]), np.array([0.0, -wheel]), np.array([0.0, wheel])),
        pose=PoseTrack(time, 0.0 * time, 0.0 * time, np.angle(np.exp(1j * theta))),
    )
    return drive, time, theta


@pytest.mark.parametrize("gap", [0.2, 0.9, 1.4, 2.3])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_full_turns_in_a_gap_are_counted(gap, side):
    drive, time, theta = spin(gap, side)
    np.testing.assert_allclose(unwound(drive, time, drive.pose.theta), theta, atol=1e-9)


def test_a_twist_tells_turns_as_well():
    drive, time, theta = spin(1.4)
    twist = TwistTrack(np.array([0.0, 5.0]), np.zeros(2), np.array([0.0, RATE]))
    by_twist = replace(drive, command=None, twist=twist)
    np.testing.assert_allclose(unwound(by_twist, time, drive.pose.theta), theta, atol=1e-9)


def test_without_wheels_the_nearer_way_round_is_taken():
    drive, time, theta = spin(1.4)
    alone = replace(drive, command=None)
    found = unwound(alone, time, drive.pose.theta)
    assert found[-1] == pytest.approx(theta[-1] - 2.0 * np.pi)


def test_a_robot_that_stands_in_a_gap_keeps_its_heading():
    drive, time, _ = spin(0.0)
    still = (time < 2.0) | (time > 4.0)
    np.testing.assert_allclose(unwound(drive, time[still], drive.pose.theta[still])[:41], 0.0, atol=1e-12)
