"""What the lane's drives leave open: which effect makes k differ from drive to drive, and what would settle it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from fsm_calib.actions.notebook import WheelRun
from fsm_calib.cli import app
from fsm_calib.diagnosis.design.from_turns import ONCE, ROLL_OUT, Straights, TurnBelief, belief_of_turns
from fsm_calib.recording.recording import RobotFacts
from fsm_calib.runner.lane_doubt import agree
from fsm_calib.world2d.parameters import parameter_table
from fsm_calib.world2d.rollout import Drive, simulate

FACTS = RobotFacts("duckie", 0.0318, 0.1, max_wheel_rate=20.0)
BEGIN = 1.0 + 1.8 * np.arange(6)
STOP = BEGIN + np.array([0.77, 0.76, 0.72, 0.82, 0.76, 0.78])
COMMAND = 0.23
LANE = """
name: worn
seed: 11
robot:
  source: fleet
  known: {camera: true, ratio_drift: 0.0}
  start_in_lane: 0.3
  effects: {wheel_eccentricity: {left: 0.04}}
plan: [lane]
output: {recording: false, frames: 0}
"""


def commands() -> Drive:
    times = np.column_stack([BEGIN, STOP]).ravel()
    held = np.tile([COMMAND, 0.0], len(BEGIN))
    return Drive(times, held, held)


def straights(turned: np.ndarray) -> Straights:
    return Straights(BEGIN, STOP, 0.15 * COMMAND / 0.23 * (STOP - BEGIN), turned, np.full(len(BEGIN), 0.003))


def driven(**values: float) -> np.ndarray:
    """Return how far a robot with these parameters turns in each drive [rad]."""
    table = parameter_table()
    robot = table.null
    for name, value in {"gain_left": 0.636, "gain_right": 0.636, **values}.items():
        robot[table.place(name.replace("__", "."))] = value
    grid = np.unique(np.concatenate([[0.0], BEGIN, STOP + ROLL_OUT]))
    heading = simulate(robot, commands(), grid, (0.0, 0.0, 0.0))[:, 2]
    return heading[np.searchsorted(grid, STOP + ROLL_OUT)] - heading[np.searchsorted(grid, BEGIN)]


def told(turned: np.ndarray) -> TurnBelief:
    return belief_of_turns(straights(turned), commands(), FACTS, 1.0)


def test_an_eccentric_wheel_is_told_from_how_the_drives_turned() -> None:
    turned = driven(wheel_eccentricity__left=0.04, wheel_eccentricity__phase_left=0.7)
    found = told(turned + 0.002 * np.random.default_rng(1).standard_normal(6))
    assert found.probabilities[0][0] == "wheel_eccentricity"
    assert found.belief.leader.names == ("wheel_eccentricity",)


def test_a_wrong_wheel_ratio_is_no_effect() -> None:
    assert told(driven(gain_left=0.66)).probabilities[0][0] == ""


def test_one_drive_that_turns_otherwise_is_something_that_happened_once() -> None:
    turned = driven()
    turned[3] += 0.06
    assert told(turned).probabilities[0][0] == ONCE


@pytest.mark.parametrize(("last", "expected"), [(-0.01, True), (0.05, False)])
def test_drives_agree_when_they_turn_alike_for_their_ways(last: float, expected: bool) -> None:
    runs = [WheelRun(1.0, 0.8, 0.13, turned, 0.004, 1.0) for turned in (-0.012, -0.008, -0.011, last)]
    assert agree(runs) is expected


def test_a_run_says_what_no_k_mends_and_which_drive_would_settle_it(tmp_path: Path) -> None:
    path = tmp_path / "worn.yaml"
    path.write_text(LANE)
    said = CliRunner().invoke(app, ["run", str(path), "--out", str(tmp_path / "out")]).stdout
    doubt = json.loads((tmp_path / "out" / "result.json").read_text())["in_lane"]["doubt"]
    assert doubt["likely"][0]["name"] == "wheel_eccentricity"
    assert doubt["drive"]["seconds"] <= 30.0
    assert doubt["sentence"] in said
    assert "no single k mends that" in (tmp_path / "out" / "report.html").read_text()
