"""Scenarios are read strictly, with every error at once."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import pytest

import fsm_calib
from fsm_calib.errors import InputError, ManyErrors
from fsm_calib.machines.supervisor import PHASES
from fsm_calib.scenario.load import load_scenario, scenario_from
from fsm_calib.scenario.schema import schema_text
from fsm_calib.scenario.section import field_texts, mirror
from fsm_calib.scenario.settings import actions_of, limits_of
from fsm_calib.scenario.world import world_of
from fsm_calib.scenario.yaml_source import parse_yaml

SCENARIOS = Path(fsm_calib.__file__).parent.parent / "scenarios"

WRONG = """\
name: bad name
seed: "1"
robots: {}
robot:
  sorce: flet
  wheel_ratio: 3
plan: [scan, wheel]
output: {frames: 1e1, report: on}
"""


def errors_of(text: str) -> list[str]:
    with pytest.raises(InputError) as caught:
        scenario_from(parse_yaml(text, "s.yaml"))
    return str(caught.value).splitlines()


def test_every_error_is_reported_at_its_place_in_the_order_of_the_file() -> None:
    places = [line.split(": ")[0] for line in errors_of(WRONG)]
    assert places == [
        "s.yaml:1:7",
        "s.yaml:2:7",
        "s.yaml:3:1",
        "s.yaml:5:3",
        "s.yaml:6:16",
        "s.yaml:7:14",
        "s.yaml:8:18",
        "s.yaml:8:31",
    ]


def test_unknown_settings_come_with_the_nearest_known_name() -> None:
    lines = errors_of(WRONG)
    assert "unknown setting 'robots'. Did you mean robot?" in lines[2]
    assert "unknown robot setting 'sorce'. Did you mean source?" in lines[3]
    assert "Did you mean wheels?" in lines[5]


def test_a_missing_setting_is_named() -> None:
    assert errors_of("seed: 1")[0].startswith("s.yaml:1:1: the setting 'name' is missing")


@pytest.mark.parametrize("text", ["", "- a", "just text", "3"])
def test_a_file_that_is_no_mapping_says_how_to_start(text: str) -> None:
    assert "a scenario is a mapping" in errors_of(text)[0]


@pytest.mark.parametrize("value", [".nan", ".inf", "true", "'1.1'"])
def test_a_number_must_be_a_finite_number(value: str) -> None:
    assert "robot.wheel_ratio" in errors_of(f"name: x\nrobot: {{wheel_ratio: {value}}}")[0]


def test_phases_come_in_the_papers_order_once_each() -> None:
    assert "in the order" in errors_of("name: x\nplan: [wheels, scan]")[0]
    assert scenario_from(parse_yaml("name: x\nplan: [scan, wheels]")).plan == ("scan", "wheels")
    assert set(PHASES) == {"focus", "scan", "orientation", "wheels", "exit", "lane"}


RUNS = [path for path in sorted(SCENARIOS.glob("*.yaml")) if not path.stem.startswith("study")]


@pytest.mark.parametrize("path", RUNS, ids=lambda path: path.stem)
def test_every_scenario_of_the_project_is_valid_named_as_its_file_and_says_what_it_shows(path: Path) -> None:
    assert load_scenario(path).name == path.stem
    comments = [
        line for line in path.read_text().splitlines() if line.startswith("#") and "$schema" not in line
    ]
    assert len(" ".join(comments)) > 60


def test_the_committed_schema_is_current() -> None:
    assert (SCENARIOS / "schema.json").read_text() == schema_text(), (
        "run: fsm-calib schema --out scenarios/schema.json"
    )


@dataclass(frozen=True)
class Inner:
    """Inner settings."""

    size: float = 2.0


@dataclass(frozen=True)
class Settings:
    """Settings of a test room.

    Parameters
    ----------
    period : float
        Time between frames [s],
        at least one exposure.
    mode : str
        How.
    """

    period: float = 0.1
    mode: Literal["a", "b"] = "a"
    inner: Inner = Inner()
    many: tuple[Inner, ...] = ()
    hidden: object = None


def test_a_mirror_has_the_names_defaults_and_texts_of_its_dataclass() -> None:
    section = mirror(Settings, skip=("hidden",), period={"gt": 0})
    assert section().build() == Settings()
    assert section.model_fields["period"].description == "Time between frames [s], at least one exposure."
    assert "hidden" not in section.model_fields


def test_a_mirror_builds_what_was_given_down_to_inner_settings() -> None:
    section = mirror(Settings, skip=("hidden",))
    given = section.model_validate_json(
        '{"period": 1, "mode": "b", "inner": {"size": 3}, "many": [{"size": 4}]}'
    )
    assert given.build(hidden=5) == Settings(1.0, "b", Inner(3.0), (Inner(4.0),), 5)


def test_field_texts_reads_several_names_on_one_line() -> None:
    assert field_texts("X.\n\nParameters\n----------\na, b : float\n    Both.\n") == {
        "a": "Both.",
        "b": "Both.",
    }


def test_errors_of_one_file_are_one_exception() -> None:
    with pytest.raises(ManyErrors) as caught:
        scenario_from(parse_yaml(WRONG, "s.yaml"))
    assert len(caught.value.errors) == 8


@pytest.mark.parametrize(
    ("text", "distance"),
    [
        ("", 1.2),
        ("scene: {field: {columns: 7}}", 0.7),
        ("scene: {field: {columns: 1}}", 0.1),
        ("scene: {field: {columns: 7}}\nactions: {drive: {distance: 0.9}}", 0.9),
    ],
)
def test_drives_are_as_long_as_the_field_allows_unless_given(text: str, distance: float) -> None:
    scenario = scenario_from(parse_yaml(f"name: drive\n{text}"))
    found = actions_of(scenario, world_of(scenario).scene)
    assert found.drive.distance == pytest.approx(distance)


def test_the_published_count_of_sweeps_changes_the_machine_and_the_actions() -> None:
    scenario = scenario_from(parse_yaml("name: sweeps\npublished: [sweep_count]"))
    scene = world_of(scenario).scene
    assert limits_of(scenario, scene).views_per_judgement == 0
    assert actions_of(scenario, scene).camera.smallest_gain == 0.0


def test_the_scans_threshold_is_one_line_of_a_scenario() -> None:
    scenario = scenario_from(parse_yaml("name: half\nactions: {camera: {target_px: 0.5}}"))
    assert actions_of(scenario, world_of(scenario).scene).camera.target_px == 0.5
