"""The forms that other people's robots leave are read with one option at most, and as what they are."""

import dataclasses

import numpy as np
import pytest
from wild_forms import SINGLE, Robot, driven, wheel_truth

from fsm_calib.diagnosis.identify.identify import identify
from fsm_calib.recording import read_recording
from fsm_calib.recording.named import Named
from fsm_calib.recording.robot_files import read_robot_file


def read(form):
    """Read a form as the commands do."""
    path, *option = form.arguments
    given = dict(zip(option[::2], option[1::2], strict=True))
    robot = read_robot_file(given["--urdf"]) if "--urdf" in given else None
    return read_recording(path, given.get("--tag-map"), Named(pose=given.get("--pose"), robot=robot))


@pytest.fixture(scope="module")
def forms(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wild")
    made = {}
    for name in ("epoch_table", "rpm_and_degrees", "millimetres", "upright_tags", "two_clocks", "described"):
        (folder / name).mkdir()
        made[name] = SINGLE[name](folder / name)
    return made


@pytest.mark.parametrize(
    ("name", "seed"), [("epoch_table", 3), ("rpm_and_degrees", 4), ("millimetres", 5), ("two_clocks", 9)]
)
def test_poses_of_a_table_are_those_of_the_drive(forms, name, seed):
    found, true = read(forms[name]).pose, driven(seed=seed).pose
    assert found.time == pytest.approx(true.time, abs=1e-5)
    assert found.x == pytest.approx(true.x, abs=1e-6)
    assert np.exp(1j * found.theta) == pytest.approx(np.exp(1j * true.theta), abs=1e-6)


def test_rates_in_rpm_are_read_as_such(forms):
    rates = read(forms["rpm_and_degrees"]).wheel_rate
    true = driven(seed=4).wheel_angle
    assert rates.left == pytest.approx(np.gradient(true.left, true.time), rel=1e-6, abs=1e-6)


def test_commands_of_another_computer_are_brought_to_the_poses(forms):
    found = read(forms["two_clocks"]).twist.time
    assert found == pytest.approx(driven(seed=9).twist.time, abs=0.06)


def test_upright_tags_tell_the_drive(forms):
    found, true = read(forms["upright_tags"]).pose, driven(seed=6, rate=8.0).pose
    assert found.x == pytest.approx(true.x, abs=0.02)
    assert found.theta == pytest.approx(np.arctan2(np.sin(true.theta), np.cos(true.theta)), abs=0.02)


def test_a_urdf_robot_is_identified_within_three_deviations(forms):
    recording = read(forms["described"])
    assert (recording.robot.wheel_radius, recording.robot.mass) == (0.05, 4.0)
    found = identify([recording.window(0.0, 12.0)])
    for name, true in wheel_truth(Robot(0.05, 0.24)).items():
        estimate = found.estimates[name]
        assert abs(estimate.value - true) < 3.0 * estimate.sd


@pytest.mark.parametrize("late", [-0.3, 0.021, 0.13])
def test_commands_that_act_late_or_on_another_clock_do_not_move_the_gains(late):
    drive = dataclasses.replace(driven(seed=30, duration=20.0), wheel_angle=None)
    twist = dataclasses.replace(drive.twist, time=drive.twist.time - late)
    found = identify([dataclasses.replace(drive, twist=twist)])
    for name in ("forward_gain", "turn_gain"):
        assert abs(found.estimates[name].value - 1.0) < 3.0 * found.estimates[name].sd
    assert found.value("command_delay") == pytest.approx(late, abs=0.005)
    assert any("beside the time constants" in note for note in found.notes)
