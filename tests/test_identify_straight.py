"""What identified wheels mean for driving straight: the pull, Duckietown's file, and a robot driven with it."""

import dataclasses
import math

import numpy as np
import pytest
from diagnosis_robots import GAIN_LEFT, GAIN_RIGHT, drive, recording, robot
from typer.testing import CliRunner

from fsm_calib.calibration_files import read_kinematics
from fsm_calib.cli import app
from fsm_calib.diagnosis.identify.result import Estimate, Identification
from fsm_calib.diagnosis.identify.straight import pull_of, straight_sentence, wheel_calibration
from fsm_calib.errors import DataError
from fsm_calib.recording.channels import TwistTrack
from fsm_calib.recording.writers import write_recording
from fsm_calib.world2d.deviation import straight_track


def found(**values):
    """Return an identification that holds these values."""
    return Identification("r", "", {name: Estimate(value, 0.001, "1") for name, value in values.items()}, {})


def driven_with(wheels, speed, duration=5.0):
    """Return the path of the simulated robot behind Duckietown's kinematics node, asked for `speed` [m/s] ahead."""
    rate = speed / wheels.wheel_radius
    right = rate * (wheels.gain + wheels.trim) / wheels.motor_constant
    left = rate * (wheels.gain - wheels.trim) / wheels.motor_constant
    return straight_track(robot(), (left, right), duration)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Return what `identify --out` printed, and the file."""
    folder = tmp_path_factory.mktemp("straight")
    manifest = write_recording(recording(3), folder / "drive")
    out = folder / "kinematics.yaml"
    result = CliRunner().invoke(app, ["identify", str(manifest), "--out", str(out)])
    assert result.exit_code == 0, result.output
    return result.stdout, out


def test_simulated_robot_goes_straight_with_the_written_trim(files):
    wheels = read_kinematics(files[1]).wheels
    path = driven_with(wheels, 0.2)
    assert path[-1, 0] == pytest.approx(1.0, abs=0.08)
    assert abs(path[-1, 1]) < 0.02
    untrimmed = driven_with(dataclasses.replace(wheels, wheel_ratio=1.0), 0.2)
    assert untrimmed[-1, 1] < -0.2


def test_written_gain_gives_the_speed_that_was_asked(files):
    path = driven_with(read_kinematics(files[1]).wheels, 0.2)
    assert (path[-1, 0] - path[-1001, 0]) / 2.0 == pytest.approx(0.2, rel=0.02)


def test_sentence_says_the_side_and_the_trim_of_the_file(files):
    said, out = files
    trim = read_kinematics(out).wheels.trim
    assert trim > 0  # the left wheel is the faster one, so that the right one has to be made faster
    assert f"to the right after 1 m; set trim to {trim:.3f}" in said


def test_pull_is_where_the_arc_ends():
    pull = pull_of(found(wheel_ratio=GAIN_LEFT / GAIN_RIGHT, axle_length=0.1))
    curvature = (GAIN_RIGHT - GAIN_LEFT) / (0.1 * 0.5 * (GAIN_LEFT + GAIN_RIGHT))
    assert pull.sideways == pytest.approx((1 - math.cos(curvature)) / curvature)
    assert pull.side == "right"
    assert pull_of(found(wheel_ratio=0.99, axle_length=0.1)).side == "left"


def test_tight_arcs_that_lead_back_turn_more_than_wide_ones():
    tight, wide = (pull_of(found(wheel_ratio=k, axle_length=0.1)) for k in (1.6, 1.25))
    assert abs(tight.sideways) < abs(wide.sideways)
    assert abs(tight.turned) > abs(wide.turned)


def test_pull_within_its_deviation_has_no_side():
    pull = pull_of(found(wheel_ratio=1.0005, axle_length=0.1))
    assert pull.side == ""
    assert pull.sentence.startswith("drives straight as far as the recording tells")


def test_commands_in_radians_per_second_are_corrected_too():
    drives = recording(0)
    track = dataclasses.replace(drives.command, unit="rad/s")
    rates = dataclasses.replace(drives, command=track)
    gains = {"wheel_gain_left": 1.1, "wheel_gain_right": 0.9}
    wheels = wheel_calibration(found(**gains, wheel_ratio=1.1 / 0.9), [rates])
    assert wheels.motor_constant == 1.0
    assert 0.9 * (wheels.gain + wheels.trim) == pytest.approx(1.0)
    assert 1.1 * (wheels.gain - wheels.trim) == pytest.approx(1.0)


def test_twists_tell_no_trim_and_nothing_is_written(tmp_path):
    commands = drive(np.random.default_rng(0), 20.0)
    twist = TwistTrack(
        commands.time, 0.3 * (commands.left + commands.right), 3 * (commands.right - commands.left)
    )
    drives = dataclasses.replace(recording(0, duration=20.0), command=None, twist=twist)
    manifest = write_recording(drives, tmp_path / "drive")
    out = tmp_path / "kinematics.yaml"
    result = CliRunner().invoke(app, ["identify", str(manifest), "--out", str(out)])
    assert result.exit_code == 1
    assert "do not tell gain and trim" in result.stderr
    assert not out.exists()


def test_wheel_that_turns_against_its_command_is_refused():
    numbers = found(wheel_ratio=-1.0, speed_at_full_left=-0.6, speed_at_full_right=0.6)
    with pytest.raises(DataError, match="against its command"):
        wheel_calibration(numbers, [recording(0)])
    assert straight_sentence(numbers, [recording(0)]) == ""
