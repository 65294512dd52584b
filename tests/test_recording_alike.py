"""Recordings that do not belong together in one call: two robots, or one that is fitted and held out."""

import dataclasses

import numpy as np
import pytest
from diagnosis_robots import engine_of
from diagnosis_robots import recording as drive
from typer.testing import CliRunner

from fsm_calib.cli import app
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.fitting.bounds import at_bounds
from fsm_calib.errors import DataError, InputError
from fsm_calib.recording import RobotFacts
from fsm_calib.recording.alike import refuse_shared, robot_warnings
from fsm_calib.recording.writers import write_recording


def of_robot(**facts):
    return dataclasses.replace(drive(duration=5.0), robot=RobotFacts(**facts))


def test_two_robots_in_one_call_are_warned_of():
    (sentence,) = robot_warnings([of_robot(name="anna"), of_robot(name="bert")])
    assert "two different robots? The recordings state different names: anna, bert" in sentence


def test_two_axles_in_one_call_are_warned_of():
    (sentence,) = robot_warnings([of_robot(axle_length=0.1), of_robot(axle_length=0.2)])
    assert "axle_length: 0.1, 0.2" in sentence


def test_one_robot_is_not_warned_of():
    same = [of_robot(name="anna", axle_length=0.1), of_robot(name="anna", axle_length=0.101), of_robot()]
    assert robot_warnings(same) == []


def test_a_copy_of_a_fitted_recording_cannot_be_held_out():
    with pytest.raises(InputError, match="it would prove itself"):
        refuse_shared([drive(1, 5.0)], [dataclasses.replace(drive(1, 5.0), source="copy")])


def test_another_recording_can_be_held_out():
    assert refuse_shared([drive(1, 5.0)], [drive(2, 5.0)]) is None


def test_diagnose_refuses_to_hold_out_what_it_fits(tmp_path):
    path = str(write_recording(drive(1, 5.0), tmp_path / "run"))
    ran = CliRunner().invoke(app, ["diagnose", path, "--holdout", str(tmp_path / "run")])
    assert ran.exit_code == 2
    assert "fitted and held out at once" in ran.stderr


@pytest.mark.parametrize("command", ["identify", "diagnose"])
def test_both_commands_warn_of_two_robots(tmp_path, monkeypatch, command):
    def stop(*_, **__):
        raise DataError("enough")

    monkeypatch.setattr(
        f"fsm_calib.diagnosis.{command.replace('identify', 'identify.identify')}.{command}", stop
    )
    paths = []
    for name in ("anna", "bert"):
        robot = dataclasses.replace(drive(1, 5.0), robot=RobotFacts(name, 0.0318, 0.1, 20.0))
        paths.append(str(write_recording(robot, tmp_path / name)))
    ran = CliRunner().invoke(app, [command, *paths])
    assert ran.exit_code == 1
    assert "two different robots?" in ran.stderr


def test_an_axle_at_its_bound_is_said():
    far = drive(3, 20.0, axle_length=0.14)
    engine = engine_of(far)
    (sentence,) = at_bounds(fit_base(engine))
    assert sentence.startswith("axle_length stands at its highest value, 0.12 m (stated: 0.1 +- 0.005)")


def test_nothing_is_said_of_a_robot_between_its_bounds():
    engine = engine_of(drive(3, 20.0))
    assert at_bounds(fit_base(engine)) == []
    assert np.isfinite(fit_base(engine).log_likelihood)
