"""Units and clocks that are clearly off are guessed aloud; what is stated or merely odd is told and left."""

import dataclasses
import math

import numpy as np
import pytest
from diagnosis_robots import recording as drive
from test_recording_checks import Nowhere

from fsm_calib.recording import PoseTrack, Recording, RobotFacts, TwistTrack, WheelPair
from fsm_calib.recording.channels import YawRateTrack
from fsm_calib.recording.checks import checked

RADIUS, AXLE = 0.033, 0.16
T = np.arange(0.0, 30.0, 0.05)
V, OMEGA = 0.2 + 0.1 * np.sin(0.4 * T), 0.6 * np.cos(0.3 * T)


def driven() -> Recording:
    """Return a drive told alike by poses, twists, wheel rates and a gyro."""
    theta = np.concatenate([[0.0], np.cumsum(OMEGA[:-1] * 0.05)])
    x, y = (np.concatenate([[0.0], np.cumsum((V * f(theta))[:-1] * 0.05)]) for f in (np.cos, np.sin))
    left, right = (V - 0.5 * AXLE * OMEGA) / RADIUS, (V + 0.5 * AXLE * OMEGA) / RADIUS
    return Recording(
        robot=RobotFacts("r", RADIUS, AXLE),
        pose=PoseTrack(T, x, y, theta),
        twist=TwistTrack(T, V, OMEGA),
        wheel_rate=WheelPair(T, left, right, "rad/s"),
        yaw_rate=YawRateTrack(T, OMEGA),
    )


def looked_at(recording, stated=()):
    return checked(recording, dict.fromkeys(recording.channels, Nowhere()), stated)


def times(recording, slot, factor, *columns):
    track = getattr(recording, slot)
    changed = {key: getattr(track, key) * factor for key in columns}
    return dataclasses.replace(recording, **{slot: dataclasses.replace(track, **changed)})


CASES = [
    ("wheel_rate", 60.0 / (2.0 * math.pi), ("left", "right"), "rpm"),
    ("wheel_rate", 180.0 / math.pi, ("left", "right"), "deg/s"),
    ("twist", 1000.0, ("v",), "mm/s"),
    ("twist", 180.0 / math.pi, ("omega",), "deg/s"),
    ("yaw_rate", 180.0 / math.pi, ("value",), "deg/s"),
    ("pose", 1000.0, ("x", "y"), "mm"),
    ("pose", 100.0, ("x", "y"), "cm"),
    ("pose", 180.0 / math.pi, ("theta",), "degrees"),
]


@pytest.mark.parametrize(("slot", "factor", "columns", "unit"), CASES)
def test_a_unit_that_is_off_is_guessed_aloud(slot, factor, columns, unit):
    found = looked_at(times(driven(), slot, factor, *columns))
    for key in columns:
        assert getattr(getattr(found, slot), key) == pytest.approx(getattr(getattr(driven(), slot), key))
    assert any(f.channel == slot and f"read as {unit}" in f.sentence for f in found.checks)


def test_millimetres_are_read_as_such_from_poses_with_much_noise():
    rng = np.random.default_rng(2)
    seen = driven()
    noise = 4.0 * rng.normal(size=(2, len(T)))  # mm: half of the way between two poses
    pose = PoseTrack(T, 1000.0 * seen.pose.x + noise[0], 1000.0 * seen.pose.y + noise[1], seen.pose.theta)
    found = looked_at(Recording(pose=pose))
    assert found.pose.x == pytest.approx(pose.x / 1000.0)


def test_headings_in_degrees_that_were_unwrapped_are_read_as_such():
    circle = 0.3 * T
    pose = PoseTrack(T, np.sin(circle), -np.cos(circle), np.degrees(circle))
    assert looked_at(Recording(pose=pose)).pose.theta == pytest.approx(circle)


def test_a_sound_drive_is_left_as_it_is():
    found = looked_at(driven())
    assert found == driven()
    assert found.checks == ()


def test_a_unit_that_is_stated_stays_and_is_told():
    found = looked_at(times(driven(), "wheel_rate", 9.549, "left", "right"), {"wheel_rate"})
    assert found.wheel_rate.left == pytest.approx(9.549 * driven().wheel_rate.left)
    assert any("look like rpm, which the manifest does not say" in f.sentence for f in found.checks)


def test_a_diameter_in_place_of_a_radius_is_told_and_left():
    found = looked_at(dataclasses.replace(driven(), robot=RobotFacts("r", 2.0 * RADIUS, AXLE)))
    assert found == dataclasses.replace(driven(), robot=RobotFacts("r", 2.0 * RADIUS, AXLE))
    assert any("a diameter in place of a radius?" in f.sentence for f in found.checks)


@pytest.mark.parametrize("shift", [7.3, -250.0])
def test_commands_of_another_clock_are_brought_to_the_poses(shift):
    plain = drive(2, 60.0)
    moved = dataclasses.replace(
        plain, command=dataclasses.replace(plain.command, time=plain.command.time + shift)
    )
    found = looked_at(moved)
    assert found.command.time == pytest.approx(plain.command.time, abs=0.35)
    assert any("brought what moved when together" in f.sentence for f in found.checks)


def test_a_delay_is_no_other_clock():
    plain = drive(2, 60.0)
    late = dataclasses.replace(
        plain, command=dataclasses.replace(plain.command, time=plain.command.time - 0.4)
    )
    assert looked_at(late).command == late.command
