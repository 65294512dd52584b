"""Study files: every error with its place; robots and variants follow from the seed alone."""

from pathlib import Path

import numpy as np
import pytest

from fsm_calib.actions.settings import ActionSettings
from fsm_calib.errors import InputError
from fsm_calib.scenario.load import scenario_from
from fsm_calib.scenario.settings import actions_of
from fsm_calib.scenario.world import world_of
from fsm_calib.scenario.yaml_source import parse_yaml
from fsm_calib.study.load import load_study, study_from, study_of_text, study_text
from fsm_calib.study.models import RobotScenario
from fsm_calib.study.schema import study_schema_text
from fsm_calib.study.store import identity
from fsm_calib.study.variants import Variant, scenario_of_robot, seed_of, variants_of

SCENARIOS = Path(__file__).parent.parent / "scenarios"


def study(text):
    return study_from(parse_yaml(text, "s.yaml"))


def error_of(text):
    with pytest.raises(InputError) as caught:
        study(text)
    return str(caught.value)


@pytest.mark.parametrize("path", sorted(SCENARIOS.glob("study*.yaml")), ids=lambda path: path.stem)
def test_every_study_of_the_project_is_valid_and_named_as_its_file(path):
    assert load_study(path).name == path.stem


def test_the_committed_schema_is_current():
    committed = (SCENARIOS / "study_schema.json").read_text()
    assert committed == study_schema_text(), "run: fsm-calib schema --study --out scenarios/study_schema.json"


def test_an_unknown_setting_is_named_with_its_place_and_the_nearest_one():
    assert "s.yaml:2:1" in error_of("name: x\nrobot: 3")
    assert "robots" in error_of("name: x\nrobot: 3")


def test_all_errors_are_told_at_once():
    said = error_of("name: x\nrobots: 0\nseed: -1")
    assert "s.yaml:2:9" in said
    assert "s.yaml:3:7" in said


def test_a_sweep_of_a_setting_that_does_not_exist_is_named_with_its_place():
    said = error_of("name: x\nsweeps:\n  - {name: a, setting: scene.field.hedding_sd, values: [0.1]}")
    assert "s.yaml:3:5" in said
    assert "heading_sd" in said


def test_a_sweep_value_that_the_setting_refuses_is_named():
    said = error_of("name: x\nsweeps:\n  - {name: a, setting: world.drive_noise, values: [0.01, 7.0]}")
    assert "s.yaml:3:5" in said
    assert "a=7" in said


def test_two_sweeps_of_one_name_are_refused():
    item = "  - {name: a, setting: world.drive_noise, values: [0.01]}\n"
    assert "two sweeps are called 'a'" in error_of(f"name: x\nsweeps:\n{item}{item}")


def test_each_correction_and_each_value_is_a_variant_beside_the_base():
    text = "name: x\ncorrections: [equation_3]\nas_published: true\n"
    found = variants_of(
        study(text + "sweeps:\n  - {name: n, setting: world.drive_noise, values: [0.0, 0.02]}")
    )
    names = ["base", "published:equation_3", "as_published", "n=0", "n=0.02"]
    assert [variant.name for variant in found] == names


def test_a_swept_setting_reaches_the_world():
    text = "name: x\nsweeps:\n  - {name: n, setting: robot.effects.wheel_slip.slip_speed, values: [0.05]}"
    loaded = study(text)
    scenario = scenario_of_robot(loaded, variants_of(loaded)[1], 0)
    assert world_of(scenario).robot.effects["wheel_slip.slip_speed"] == 0.05


SHORT_FIELD = "name: x\nscenario: {scene: {field: {columns: 7}}}"
SWEPT_FIELD = (
    "name: x\nsweeps:\n  - {name: c, setting: scene.field.columns, whole: true, values: [7], unit: markers}"
)

DISTANCE = "  - {name: d, setting: actions.drive.distance, values: [1.25]}"


def drive_distance(scenario):
    return actions_of(scenario, world_of(scenario).scene).drive.distance


@pytest.mark.parametrize(("text", "variant"), [(SHORT_FIELD, 0), (SWEPT_FIELD, 1)], ids=["given", "swept"])
def test_a_robot_of_a_study_shortens_its_drives_to_the_field_as_a_robot_by_itself_does(text, variant):
    loaded = study_of_text(study_text(study(text)))  # as a worker sees it
    robot = scenario_of_robot(loaded, variants_of(loaded)[variant], 0)
    alone = scenario_from(parse_yaml("name: x\nscene: {field: {columns: 7}}", "alone.yaml"))
    assert drive_distance(robot) == drive_distance(alone) < ActionSettings().drive.distance


def test_a_distance_that_the_study_gives_is_kept_in_every_variant():
    loaded = study(f"{SHORT_FIELD}\nsweeps:\n{DISTANCE}")
    robot = scenario_of_robot(loaded, variants_of(loaded)[1], 0)
    assert drive_distance(robot) == 1.25


def test_what_a_study_does_not_give_has_the_defaults_of_studies():
    scenario = scenario_of_robot(study("name: x"), Variant(), 0)
    assert scenario.plan == RobotScenario().plan
    assert scenario.output == RobotScenario().output


def test_a_robots_seed_depends_on_study_seed_and_number_alone():
    few, many = study("name: x\nseed: 4\nrobots: 2"), study("name: x\nseed: 4\nrobots: 900")
    assert scenario_of_robot(few, Variant(), 1) == scenario_of_robot(many, Variant(), 1)
    assert len({seed_of(seed, robot) for seed in range(20) for robot in range(50)}) == 1000


def test_all_variants_run_the_same_robot():
    loaded = study("name: x\ncorrections: [equation_3]")
    first, second = (world_of(scenario_of_robot(loaded, item, 3)).robot for item in variants_of(loaded))
    assert first.wheel_ratio == second.wheel_ratio
    assert np.array_equal(first.camera.matrix, second.camera.matrix)


def test_one_robot_again_and_again_differs_in_its_seed_alone():
    loaded = study("name: x\nsame_robot: true")
    specs = [world_of(scenario_of_robot(loaded, Variant(), robot)) for robot in (0, 1)]
    assert specs[0].robot.wheel_ratio == specs[1].robot.wheel_ratio
    assert np.array_equal(specs[0].robot.camera.matrix, specs[1].robot.camera.matrix)
    assert specs[0].seed != specs[1].seed


def test_a_study_survives_the_way_to_a_worker():
    loaded = load_study(SCENARIOS / "study_sweeps.yaml")
    assert study_of_text(study_text(loaded)) == loaded


def test_the_number_of_robots_does_not_make_another_study():
    loaded = study("name: x\nrobots: 3")
    assert identity(loaded) == identity(loaded.model_copy(update={"robots": 30}))
    assert identity(loaded) != identity(loaded.model_copy(update={"seed": 30}))
