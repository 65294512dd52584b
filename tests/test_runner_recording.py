"""The run's own drive is a recording that reads back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fsm_calib.journal import JOURNAL_NAME, read_journal
from fsm_calib.recording.read import read_recording
from fsm_calib.runner.recording import commands_of, poses_of, recording_of, states_of, write_drive
from fsm_calib.runner.run import run_scenario
from fsm_calib.scenario.load import scenario_from
from fsm_calib.scenario.models import OutputSection
from fsm_calib.scenario.yaml_source import parse_yaml

EVENTS = [
    {"time": 0.5, "path": "between", "dest": "wheels/forward", "commands": [[0.0, 0.0, 0.0]]},
    {"time": 2.0, "path": "wheels/forward", "dest": "done", "commands": [[0.5, 0.1, 0.1], [0.5, 0.2, 0.3]]},
    {"time": 2.0, "path": "done", "dest": "done", "commands": [[2.0, 0.0, 0.0]]},
]


def test_of_two_commands_at_one_time_the_last_acts() -> None:
    commands = commands_of(EVENTS)
    assert commands.time.tolist() == [0.0, 0.5, 2.0]
    assert commands.left.tolist() == [0.0, 0.2, 0.0]
    assert commands.right.tolist() == [0.0, 0.3, 0.0]


def test_a_state_holds_from_its_entry_to_the_next_one() -> None:
    states = states_of(EVENTS)
    assert [states.at(time) for time in (0.1, 0.6, 3.0)] == ["between", "wheels/forward", "done"]


def test_poses_are_the_path_with_the_noise_that_was_asked_for() -> None:
    trace = np.column_stack([np.arange(4000) * 0.02, np.zeros((4000, 3))])
    track = poses_of(trace, OutputSection(pose_noise=0.002, heading_noise=0.01), np.random.default_rng(1))
    assert track.time[1] - track.time[0] == pytest.approx(0.04)
    assert np.std(track.x) == pytest.approx(0.002, rel=0.1)
    assert np.std(track.theta) == pytest.approx(0.01, rel=0.1)


@pytest.mark.parametrize("bag", ["ros1", "mcap"])
def test_a_run_leaves_a_recording_of_its_drive(tmp_path: Path, bag: str) -> None:
    text = f"""
name: short
robot: {{source: nominal, known: {{camera: true}}}}
plan: [orientation]
output: {{report: false, frames: 0, bag: {bag}}}
"""
    finished = run_scenario(scenario_from(parse_yaml(text)), tmp_path)
    recording = read_recording(tmp_path / "recording" / "recording.yaml")
    truth = finished.session.world.truth.trace
    assert recording.state is not None
    assert recording.state.path[-1] == "done"
    assert recording.pose is not None
    assert np.abs(recording.pose.x - np.interp(recording.pose.time, truth[:, 0], truth[:, 1])).max() < 0.01
    written = recording_of(finished.session, list(read_journal(tmp_path / JOURNAL_NAME)))
    name = "drive.bag" if bag == "ros1" else "drive_ros2"
    assert read_recording(tmp_path / "recording" / name) == recording
    assert recording.channels == written.channels
    write_drive(tmp_path, finished.session)
    assert read_recording(tmp_path / "recording" / name) == recording
