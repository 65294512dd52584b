"""What a diagnosis takes in: positions without headings, wheel angles as the input, robots whose size nobody stated."""

import dataclasses

import numpy as np
import pytest
from diagnosis_robots import engine_of
from diagnosis_robots import recording as drive
from wild_forms import Robot, driven

from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.identify.yaw import identify_from_yaw_rate
from fsm_calib.diagnosis.inputs import with_input
from fsm_calib.diagnosis.intake import take_in
from fsm_calib.diagnosis.replay.prepared import prepare
from fsm_calib.errors import DataError
from fsm_calib.recording import RobotFacts, WheelPair
from fsm_calib.recording.channels import YawRateTrack
from fsm_calib.recording.recording import Recording
from fsm_calib.world2d.parameters import parameter_table


def fitted(recording):
    """Return the base robot's numbers by name, of a recording as a diagnosis takes it in."""
    taken = take_in([recording])
    fit = fit_base(engine_of(*taken.train))
    return taken, {parameter_table().names[slot.place]: value for slot, value, _ in fit.numbers()}


def test_positions_without_headings_are_fitted():
    full = drive(1, 30.0)
    bare = dataclasses.replace(
        full, pose=dataclasses.replace(full.pose, theta=np.full(len(full.pose), np.nan))
    )
    taken, found = fitted(bare)
    assert any("no heading was measured" in note for note in taken.notes)
    assert not prepare(taken.train[0]).seen[:, 2].any()
    assert (found["gain_left"], found["gain_right"]) == pytest.approx((0.66, 0.61), rel=0.03)
    assert found["axle_length"] == pytest.approx(0.1, rel=0.03)


def test_positions_of_a_robot_that_stands_still_are_refused_with_the_cure():
    full = drive(1, 10.0)
    still = dataclasses.replace(full.pose, x=np.zeros(len(full.pose)), y=np.zeros(len(full.pose)))
    still = dataclasses.replace(still, theta=np.full(len(still), np.nan))
    with pytest.raises(DataError, match="headings cannot be reckoned"):
        prepare(dataclasses.replace(full, pose=still))


def test_wheel_angles_are_the_input_where_no_command_was_logged():
    angles = driven(seed=1, duration=12.0)
    made = with_input(dataclasses.replace(angles, twist=None))
    assert made.wheel_angle is None
    way = np.sum(made.wheel_rate.left[:-1] * np.diff(made.wheel_rate.time))
    assert way == pytest.approx(angles.wheel_angle.left[len(angles.wheel_angle) - 2], abs=0.05)
    assert with_input(angles) is angles


def test_a_size_that_nobody_stated_is_identified_first():
    robot = Robot(0.1, 0.5, 20.0, 0.8, 1.2)
    taken, found = fitted(driven(robot, 8, duration=16.0))
    assert any(note.startswith("not stated, so identified first: wheel_radius 0.1") for note in taken.notes)
    assert taken.train[0].robot.axle_length == pytest.approx(0.5, rel=0.02)
    assert found["axle_length"] == pytest.approx(0.5, rel=0.02)
    assert found["wheel_radius_left"] == pytest.approx(0.1, rel=0.02)


def test_stated_sizes_are_left_and_nothing_is_identified():
    taken = take_in([drive(1, 10.0)])
    assert taken.train[0].robot == drive(1, 10.0).robot
    assert taken.notes == ()


def test_wheels_that_only_drive_straight_tell_no_gain_beside_a_gyro():
    t = np.arange(0.0, 20.0, 0.05)
    straight = Recording(
        RobotFacts(axle_length=0.5),
        wheel_speed=WheelPair(t, np.ones(len(t)), np.ones(len(t)), "m/s"),
        yaw_rate=YawRateTrack(t, np.random.default_rng(0).normal(0.0, 0.01, len(t))),
    )
    found = identify_from_yaw_rate([straight])
    assert found.estimates["wheel_gain_over_axle_left"].value is None
