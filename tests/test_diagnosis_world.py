"""The improved world: run, identify and diagnose take the file that a diagnosis writes."""

import json
from pathlib import Path

import numpy as np
import pytest
from diagnosis_robots import GAIN_LEFT, GAIN_RIGHT, recording
from typer.testing import CliRunner

from fsm_calib.cli import app
from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.recording.writers import write_recording
from fsm_calib.report.diagnosis_world import world_text
from fsm_calib.runner.run import run_scenario
from fsm_calib.scenario.load import load_scenario
from fsm_calib.scenario.world import physics_of, world_of
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

OFFSET = 0.08
CONSIDERED = ("motor_deadband", "floor_tilt", "wheel_eccentricity")
WITHOUT = [name for name in registry() if name not in CONSIDERED]
TRUE_RATIO = GAIN_LEFT / GAIN_RIGHT


def drives(**effects):
    return [recording(seed, 30.0, **effects) for seed in (1, 2)]


def world_of_drives(path, **effects):
    path.write_text(world_text(diagnose(drives(**effects), without=WITHOUT)), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def world(tmp_path_factory) -> Path:
    return world_of_drives(tmp_path_factory.mktemp("worlds") / "world.yaml", motor_deadband__offset=OFFSET)


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> list[str]:
    folder = tmp_path_factory.mktemp("drives")
    found = drives(motor_deadband__offset=OFFSET)
    return [str(write_recording(one, folder / str(i))) for i, one in enumerate(found)]


def command(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def test_a_run_drives_the_robot_of_the_improved_world(world, tmp_path):
    scenario = load_scenario(world)
    table, vector = parameter_table(), world_of(scenario).robot.parameters()
    assert vector[table.place("motor_deadband.offset")] == pytest.approx(OFFSET, abs=0.003)
    assert vector[table.place("gain_left")] == pytest.approx(GAIN_LEFT, rel=0.01)
    knows = scenario.robot.known.model_copy(update={"camera": True})
    short = scenario.model_copy(
        update={
            "plan": ("orientation",),
            "robot": scenario.robot.model_copy(update={"known": knows}),
            "output": scenario.output.model_copy(update={"report": False, "frames": 0}),
        }
    )
    assert run_scenario(short, tmp_path).result["outcome"] == "done"


def test_the_run_command_accepts_the_improved_world(world):
    assert command("validate", world).exit_code == 0


def test_identify_in_the_improved_world_finds_the_robot_that_the_dead_band_hides(world, files, tmp_path):
    out = tmp_path / "robot.json"
    answer = command("identify", *files, "--world", world, "--json", out)
    assert answer.exit_code == 0, answer.output
    told = json.loads(out.read_text())
    assert told["speed_at_full_left"]["value"] == pytest.approx(GAIN_LEFT, rel=0.005)
    assert told["speed_at_full_right"]["value"] == pytest.approx(GAIN_RIGHT, rel=0.005)
    assert told["wheel_ratio"]["value"] == pytest.approx(TRUE_RATIO, abs=4 * told["wheel_ratio"]["sd"])
    assert abs(told["sensor"]["x"]["value"]) < 4 * told["sensor"]["x"]["sd"]
    alone = tmp_path / "alone.json"
    assert command("identify", *files, "--json", alone).exit_code == 0
    without = json.loads(alone.read_text())["speed_at_full_left"]["value"]
    assert abs(without - GAIN_LEFT) > 10 * abs(told["speed_at_full_left"]["value"] - GAIN_LEFT)


def test_diagnose_against_the_improved_world_says_match_and_leaves_the_file(world, files, tmp_path):
    before, out = world.read_text(), tmp_path / "verdict.json"
    choices = [text for name in WITHOUT for text in ("--without", name)]
    answer = command("diagnose", *files, "--world", world, "--json", out, *choices)
    assert answer.exit_code == 0, answer.output
    assert json.loads(out.read_text())["verdict"] == "match"
    assert world.read_text() == before


def test_diagnose_writes_the_improved_world_where_there_is_none_yet(files, tmp_path):
    world = tmp_path / "new.yaml"
    choices = [text for name in WITHOUT for text in ("--without", name)]
    assert command("diagnose", *files, "--world", world, *choices).exit_code == 0
    assert load_scenario(world).robot.effects.motor_deadband.offset == pytest.approx(OFFSET, abs=0.003)


def test_a_world_with_the_wrong_size_gets_the_whole_size_named():
    found = diagnose(
        drives(motor_deadband__offset=OFFSET), without=WITHOUT, world={"motor_deadband.offset": 0.03}
    )
    assert [effect.name for effect in found.verdict.effects] == ["motor_deadband"]
    assert found.verdict.effects[0].parameters["offset"].value == pytest.approx(OFFSET, abs=0.003)


def test_a_wheels_phase_is_found_anew_in_each_recording(tmp_path):
    eccentric = {"wheel_eccentricity__left": 0.12}
    world = world_of_drives(tmp_path / "world.yaml", **eccentric)
    turned = [recording(seed, 30.0, wheel_eccentricity__phase_left=2.0, **eccentric) for seed in (3, 4)]
    found = diagnose(turned, without=WITHOUT, world=physics_of(world))
    assert found.verdict.verdict == "match"
    place = parameter_table().place("wheel_eccentricity.phase_left")
    phases = found.decision.base.values[:, place]
    assert np.all(np.cos(phases - 2.0) > 0.8)


def test_a_world_that_is_no_scenario_is_told_with_its_place(files, tmp_path):
    world = tmp_path / "broken.yaml"
    world.write_text("name: broken\nrobot: {effects: {motor_deadbnd: {offset: 0.1}}}\n")
    for name in ("identify", "diagnose"):
        answer = command(name, *files, "--world", world)
        assert answer.exit_code == 2
        assert "broken.yaml:2" in answer.output
