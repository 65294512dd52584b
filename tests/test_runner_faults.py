"""Each fault scenario ends in the failure it is named after, with the reason, the cure and the wheels at zero."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from fsm_calib.runner.run import Finished, run_scenario
from fsm_calib.scenario.load import load_scenario
from fsm_calib.scenario.models import OutputSection, Scenario

SCENARIOS = Path(__file__).parent.parent / "scenarios"
FAILURES = {
    "fault_dead_wheel": "wheel_dead",
    "fault_dropped_frames": "camera_silent",
    "fault_frozen_frames": "camera_frozen",
    "fault_missing_board": "board_missing",
    "fault_missing_marker": "marker_missing",
    "fault_wall": "wall_hit",
}
NO_PICTURES = OutputSection(report=False, recording=False, frames=0)


def scenario_named(name: str) -> Scenario:
    return load_scenario(SCENARIOS / f"{name}.yaml").model_copy(update={"output": NO_PICTURES})


@pytest.fixture(scope="module", params=FAILURES)
def failed(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Finished]:
    """A run of every fault scenario."""
    directory = tmp_path_factory.mktemp(request.param)
    return request.param, run_scenario(scenario_named(request.param), directory)


def test_there_is_a_scenario_for_every_failure_listed_and_no_other() -> None:
    assert {path.stem for path in SCENARIOS.glob("fault_*.yaml")} == set(FAILURES)


def test_a_fault_ends_in_its_named_failure_with_one_sentence_of_cure_and_the_wheels_at_zero(
    failed: tuple[str, Finished],
) -> None:
    name, finished = failed
    failure = finished.result["failure"]
    assert finished.result["outcome"] == "failed"
    assert failure["name"] == FAILURES[name]
    assert failure["reason"].strip()
    assert failure["cure"].strip().endswith(".")
    assert failure["cure"].count(".") == 1
    robot = finished.session.world.robot
    assert robot.command_log[-1][1].left == robot.command_log[-1][1].right == 0.0


def test_a_failed_run_leaves_a_result_and_no_file_of_an_unfinished_calibration(
    failed: tuple[str, Finished],
) -> None:
    _, finished = failed
    written = json.loads((finished.directory / "result.json").read_text())
    assert written["failure"] == finished.result["failure"]
    assert not list((finished.directory / "calibrations").rglob("kinematics/*.yaml"))
