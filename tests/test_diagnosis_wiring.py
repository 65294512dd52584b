"""Sides, signs and headings that were mixed up are read off the drives, told, and put right before a fit."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_robots import recording, with_encoders

from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.diagnosis.intake import take_in
from fsm_calib.diagnosis.wiring import as_wired
from fsm_calib.recording.channels import CommandTrack, TwistTrack

SPEED, AXLE = 0.636, 0.1  # m/s at command 1, m


def exchanged(track):
    return replace(track, left=track.right, right=track.left)


def one_reversed(track):
    return replace(track, left=-track.left)


def both_reversed(track):
    return replace(track, left=-track.left, right=-track.right)


def commanded(seen, change):
    return replace(seen, command=change(seen.command))


def told_twists(seen, ahead=1.0, aside=1.0):
    """Return the recording of a robot that was told speed and turn rate, their signs changed."""
    track = seen.command
    v, omega = SPEED * (track.left + track.right) / 2.0, SPEED * (track.right - track.left) / AXLE
    return replace(seen, command=None, twist=TwistTrack(track.time, ahead * v, aside * omega))


def turned(seen, angle):
    return replace(seen, pose=replace(seen.pose, theta=seen.pose.theta + angle))


def mirrored(seen):
    return replace(seen, pose=replace(seen.pose, y=-seen.pose.y, theta=-seen.pose.theta))


def same(one, other):
    return np.array_equal(one.left, other.left) and np.array_equal(one.right, other.right)


def test_a_robot_that_is_wired_as_stated_is_left_as_it_is():
    seen = recording(0)
    (left_alone,), _, told = as_wired([seen])
    assert same(left_alone.command, seen.command)
    assert left_alone.pose is seen.pose
    assert told == []


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (exchanged, "left and right of the commands are exchanged"),
        (both_reversed, "the signs of both commands are reversed"),
        (one_reversed, "the sign of the left one of the commands is reversed"),
    ],
)
def test_wheels_that_were_mixed_up_are_put_right_and_told(change, said):
    seen = recording(0)
    (found,), _, told = as_wired([commanded(seen, change)])
    assert same(found.command, seen.command)
    assert len(told) == 1
    assert told[0].startswith(said)


def test_what_the_fitted_drives_tell_holds_for_those_held_out():
    seen, kept_back = recording(0), recording(1)
    _, (found,), _ = as_wired([commanded(seen, exchanged)], [commanded(kept_back, exchanged)])
    assert same(found.command, kept_back.command)


@pytest.mark.parametrize(("ahead", "aside"), [(1.0, -1.0), (-1.0, -1.0)])
def test_twists_with_a_sign_turned_round_are_put_right(ahead, aside):
    meant = told_twists(recording(0)).twist
    (found,), _, told = as_wired([told_twists(recording(0), ahead, aside)])
    assert found.twist.v == pytest.approx(meant.v)
    assert found.twist.omega == pytest.approx(meant.omega)
    assert len(told) == 1


@pytest.mark.parametrize("quarters", [1, 2, -1])
def test_a_tag_that_is_quarters_round_is_turned_to_where_the_robot_drives(quarters):
    seen = recording(0)
    (found,), _, (said,) = as_wired([turned(seen, -quarters * np.pi / 2.0)])
    assert np.cos(found.pose.theta - seen.pose.theta) == pytest.approx(1.0)
    assert f"{90 * quarters:+d} deg" in said


def test_a_tag_that_is_some_degrees_askew_stays():
    seen = turned(recording(0), 0.3)
    (found,), _, told = as_wired([seen])
    assert found.pose is seen.pose
    assert told == []


def test_encoders_that_were_exchanged_are_put_right():
    seen = with_encoders(0)
    (found,), _, told = as_wired([replace(seen, wheel_angle=exchanged(seen.wheel_angle))])
    assert same(found.wheel_angle, seen.wheel_angle)
    assert same(found.command, seen.command)
    assert told[0].startswith("left and right of the wheel channels are exchanged")


def test_commands_that_have_nothing_to_do_with_the_poses_change_nothing():
    seen = recording(0)
    rng = np.random.default_rng(3)
    time = np.arange(0.0, 40.0, 0.7)
    other = CommandTrack(time, rng.uniform(-0.5, 0.5, len(time)), rng.uniform(-0.5, 0.5, len(time)))
    assert as_wired([replace(seen, command=other)])[2] == []


def test_a_map_that_is_mirrored_looks_as_exchanged_wheels_do():
    (found,), _, (said,) = as_wired([mirrored(recording(0))])
    assert same(found.command, exchanged(recording(0).command))
    assert "mirrored" in said


def test_the_intake_tells_what_was_put_right():
    taken = take_in([commanded(recording(0), exchanged)])
    assert any("exchanged" in note for note in taken.notes)


def test_a_robot_without_another_fault_than_its_wiring_matches():
    found = diagnose([commanded(recording(seed), exchanged) for seed in (0, 1)])
    assert found.decision.outcome == "match"
