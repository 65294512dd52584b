"""What `identify` tells of the gains of wheels: each number under one name, and what would tell the others."""

import json
from dataclasses import replace

import pytest
from diagnosis_robots import recording
from typer.testing import CliRunner

import fsm_calib
from fsm_calib.cli import app
from fsm_calib.diagnosis.identify.result import Estimate, Identification, told_once
from fsm_calib.recording import Recording, RobotFacts
from fsm_calib.recording.writers import write_recording


def told(radius=None, rate=None, unit="m/s", **found):
    """Return what is told of a robot with these facts whose gains have a unit."""
    numbers = {"wheel_gain_left": 0.6, "wheel_gain_right": 0.7, "speed_at_full_left": 0.6, **found}
    estimates = {name: Estimate(value, 0.001, unit) for name, value in numbers.items()}
    facts = RobotFacts("r", wheel_radius=radius, max_wheel_rate=rate)
    return told_once(Identification("r", "", estimates, {}), [Recording(facts)])


def test_a_robot_without_a_stated_speed_has_each_number_once_and_the_json_keeps_both_names(tmp_path):
    drive = recording(3, duration=25.0)
    bare = replace(drive, robot=replace(drive.robot, wheel_radius=None, max_wheel_rate=None))
    path, out = write_recording(bare, tmp_path / "drive"), tmp_path / "robot.json"
    ran = CliRunner().invoke(app, ["identify", str(path), "--json", str(out)])
    assert ran.exit_code == 0, ran.output
    assert ran.stdout.count("speed_at_full_left") == 1
    assert "wheel_gain_left" not in ran.stdout
    assert "state the robot's wheel_radius and max_wheel_rate to have it" in ran.stdout
    plain = json.loads(out.read_text())
    assert plain["wheel_gain_left"] == plain["speed_at_full_left"]
    assert [name for name, _ in fsm_calib.identify(bare).rows if name.startswith("wheel_gain")] == [
        "wheel_gain"
    ]


@pytest.mark.parametrize(
    ("facts", "lacking"),
    [
        ({}, "wheel_radius and max_wheel_rate"),
        ({"radius": 0.03}, "max_wheel_rate"),
        ({"rate": 20.0}, "wheel_radius"),
        ({"wheel_radius_left": 0.03, "wheel_radius_right": 0.03}, "max_wheel_rate"),
    ],
)
def test_what_the_gain_of_a_wheel_lacks_is_said(facts, lacking):
    assert f"; state the robot's {lacking} to have it" in told(**facts)["wheel_gain"]["reason"]


@pytest.mark.parametrize("unit", ["1", "m"])
def test_gains_that_are_numbers_of_their_own_are_told(unit):
    assert set(told(0.03, 20.0, unit)) == {"wheel_gain_left", "wheel_gain_right", "speed_at_full_left"}


def test_the_sensor_is_told_last():
    assert list(told(**{"sensor.x": 0.01, "axle_length": 0.1}))[-1] == "sensor.x"
