"""The world that an `unexplained` verdict writes: one robot, in its comment as in its values, with what improves it."""

import re
from dataclasses import replace

import pytest
import yaml
from diagnosis_robots import recording

from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.fitting.fit import Engine
from fsm_calib.diagnosis.proof.gates import DEFAULT_GATES
from fsm_calib.diagnosis.proof.heldout import compare
from fsm_calib.diagnosis.replay.prepared import prepare
from fsm_calib.diagnosis.replay.simulator import make_simulator
from fsm_calib.report.diagnosis_world import world_text
from fsm_calib.scenario.world import physics_of
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

NEAREST = "motor_gain_curve"
WITHOUT = [name for name in registry() if name != NEAREST]
TRAIN, NEW = (0, 1), 2


def drive(seed):
    """Return a drive of a robot with a dead zone, which the catalogue of these tests does not know."""
    return recording(seed, motor_deadband__offset=0.08)


@pytest.fixture(scope="module")
def found():
    """Return the diagnosis of one who says no name that is less than 0.9 sure."""
    strict = replace(DEFAULT_GATES, least_confidence=0.9)
    return diagnose([drive(seed) for seed in TRAIN], [drive(NEW)], without=WITHOUT, gates=strict)


def test_it_has_what_improves_the_fit_though_no_name_is_sure(found):
    assert found.verdict.verdict == "unexplained"
    assert not found.verdict.effects
    assert list(yaml.safe_load(world_text(found))["robot"]["effects"]) == [NEAREST]


def test_its_comment_and_its_values_are_one_robot(found):
    text = world_text(found)
    said = {name: float(value) for name, value in re.findall(r"^#   (\w+): (\S+) ±", text, re.MULTILINE)}
    robot = yaml.safe_load(text)["robot"]
    for name, value in robot["base"].items():
        assert said[name] == pytest.approx(value, rel=1e-4)
    assert robot["wheel_ratio"] == pytest.approx(said["gain_left"] / said["gain_right"], rel=1e-4)
    usual = parameter_table().null[parameter_table().place("gain_left")]
    assert robot["speed"] == pytest.approx(0.5 * (said["gain_left"] + said["gain_right"]) / usual, rel=1e-4)


def test_its_robot_predicts_a_new_drive_as_well_as_the_diagnosis_does(found, tmp_path):
    world = tmp_path / "world.yaml"
    world.write_text(world_text(found), encoding="utf-8")
    physics = physics_of(world)
    trained = Engine(tuple(make_simulator(prepare(drive(seed)), physics) for seed in TRAIN))
    base = fit_base(trained)
    again = compare((make_simulator(prepare(drive(NEW)), physics),), base, base, new=True).before
    before, after = found.verdict.holdout.before, found.verdict.holdout.after
    assert again.theta_rad == pytest.approx(after.theta_rad, rel=0.05)
    assert again.theta_rad < 0.6 * before.theta_rad
