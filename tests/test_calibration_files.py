"""Duckietown's kinematics file: its form, and that it loads back."""

from __future__ import annotations

from datetime import UTC, datetime

import pytest
import yaml

from fsm_calib.calibration_files import kinematics_text, read_kinematics, write_kinematics
from fsm_calib.errors import InputError
from fsm_calib.types import WheelCalibration

WHEN = datetime(2026, 11, 21, 12, 30, 5, tzinfo=UTC)
DUCKIETOWN_KEYS = {
    "baseline",
    "calibration_time",
    "gain",
    "k",
    "limit",
    "omega_max",
    "radius",
    "trim",
    "v_max",
}


def test_it_has_the_keys_of_a_duckietown_file_and_plain_numbers() -> None:
    values = yaml.safe_load(kinematics_text(WheelCalibration(wheel_ratio=1.1), WHEN, "two\nlines"))
    assert set(values) == DUCKIETOWN_KEYS
    assert values["trim"] == pytest.approx(0.1 / 2.1, abs=1e-6)
    assert values["calibration_time"] == "2026-11-21-12-30-05"


def test_it_loads_back(tmp_path) -> None:
    wheels = WheelCalibration(wheel_ratio=0.93, gain=1.1, axle_length=0.102)
    path = write_kinematics(tmp_path, "robot", wheels, WHEN, "by a test")
    read = read_kinematics(path)
    assert path == tmp_path / "kinematics" / "robot.yaml"
    assert read.wheels.wheel_ratio == pytest.approx(0.93, abs=2e-6)
    assert (read.wheels.gain, read.wheels.axle_length) == (1.1, 0.102)
    assert read.calibrated == "2026-11-21-12-30-05"


def test_drivers_equation_gives_commands_in_the_wheel_ratio() -> None:
    wheels = WheelCalibration(wheel_ratio=1.08, gain=1.03)
    omega = 5.0
    right = omega * (wheels.gain + wheels.trim) / wheels.motor_constant
    left = omega * (wheels.gain - wheels.trim) / wheels.motor_constant
    assert right / left == pytest.approx(1.08)


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("gain: 1.0\n", "", "the key 'gain' is missing"),
        ("gain: 1.0", "gain: true", "gain is True"),
        ("limit: 1.0", "limit: .nan", "limit is nan"),
        ("trim: 0.0", "trim: -1.5", "a wheel never turns"),
    ],
)
def test_a_wrong_file_is_told_with_its_place(tmp_path, old: str, new: str, problem: str) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(kinematics_text(WheelCalibration(), WHEN).replace(old, new))
    with pytest.raises(InputError, match=rf"robot\.yaml:\d+:\d+: .*{problem}"):
        read_kinematics(path)
