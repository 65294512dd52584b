"""A fleet of small simulated robots in one call: worst first, resumable, one broken recording among them."""

import csv
import json

import numpy as np
import pytest
from diagnosis_robots import recording
from typer.testing import CliRunner

from fsm_calib.cli import app
from fsm_calib.errors import InputError
from fsm_calib.fleet.folders import robots_in
from fsm_calib.fleet.run import worst_first
from fsm_calib.recording import Recording, TwistTrack
from fsm_calib.recording.untold import why_no_pull
from fsm_calib.recording.writers import write_recording
from fsm_calib.report.fleet import cells, fleet_page

GAINS_LEFT = {"little": 0.62, "much": 0.70, "left": 0.58}
"""Speed of the left wheel at command 1 [m/s]; the right one has 0.61."""


def fleet(*arguments):
    return CliRunner().invoke(app, ["fleet", "--jobs", "1", *map(str, arguments)])


@pytest.fixture(scope="module")
def robots(tmp_path_factory):
    folder = tmp_path_factory.mktemp("robots")
    for seed, (name, gain) in enumerate(GAINS_LEFT.items()):
        write_recording(recording(seed, duration=20.0, gain_left=gain), folder / name)
    (folder / "broken").mkdir()
    (folder / "broken" / "recording.yaml").write_text("format: [")
    return folder


@pytest.fixture(scope="module")
def ran(robots, tmp_path_factory):
    out = tmp_path_factory.mktemp("out")
    return fleet(robots, "--out", out), out


def test_robots_come_worst_first_and_the_broken_one_last(ran):
    result, out = ran
    assert result.exit_code == 0, result.output
    table = list(csv.DictReader((out / "fleet.csv").open()))
    assert [row["robot"] for row in table] == ["much", "left", "little", "broken"]
    assert [row["pulls"] for row in table[:2]] == ["right", "left"]
    assert float(table[0]["wheel_ratio"]) == pytest.approx(0.70 / 0.61, rel=0.01)
    assert "recording.yaml" in table[-1]["error"]


def test_page_and_words_name_every_robot(ran):
    result, out = ran
    html = (out / "index.html").read_text()
    for name in (*GAINS_LEFT, "broken"):
        assert name in html
        assert f"{name}: " in result.stdout
    assert html.index("much") < html.index("little") < html.index("Without an answer")


def test_robots_that_are_there_are_not_found_out_again(robots, ran):
    _, out = ran
    kept = out / "robots" / "much.json"
    row = json.loads(kept.read_text())
    kept.write_text(json.dumps(row | {"sentence": "as it was kept"}))
    (out / "robots" / "little.json").unlink()
    again = fleet(robots, "--out", out)
    kept.write_text(json.dumps(row))
    assert again.exit_code == 0
    assert "much: as it was kept" in again.stdout
    assert "2 of 4 robots are there" in again.stderr
    assert (out / "robots" / "little.json").exists()


def test_a_cluster_of_worker_processes_says_the_same_of_every_robot(robots, ran, tmp_path):
    distributed = pytest.importorskip("distributed")
    settings = {"n_workers": 1, "threads_per_worker": 1, "processes": True, "dashboard_address": None}
    with distributed.LocalCluster(**settings) as cluster:
        address = cluster.scheduler_address
        result = fleet(robots, "--out", tmp_path, "--backend", "dask", "--address", address)
    assert result.exit_code == 0, result.output
    assert (tmp_path / "fleet.csv").read_text() == (ran[1] / "fleet.csv").read_text()


def test_a_back_end_that_there_is_not_is_wrong_use(robots, tmp_path):
    result = fleet(robots, "--out", tmp_path / "out", "--backend", "spark")
    assert result.exit_code == 2
    assert "spark" in result.stderr
    assert not (tmp_path / "out").exists()


def test_recording_that_changed_is_read_again(robots, tmp_path):
    assert fleet(robots / "left", "--out", tmp_path).exit_code == 0
    with (robots / "left" / "recording.yaml").open("a") as file:
        file.write("\n")
    again = fleet(robots / "left", "--out", tmp_path)
    assert "0 of 1 robots are there" in again.stderr


def test_speeds_of_the_robot_tell_no_pull_and_the_cure_is_said():
    twist = TwistTrack(np.array([0.0, 6.0]), np.array([0.2, 0.1]), np.array([0.3, -0.6]))
    assert "record the wheels' own commands" in why_no_pull([Recording(twist=twist)])


def test_the_page_says_why_no_pull_is_told():
    row = {"robot": "duckie", "recordings": ["a"], "straight": None, "trim": None, "untold": "no commands"}
    assert "not told: no commands" in fleet_page([cells(row)])


def test_fleet_of_broken_recordings_fails_with_the_reason(robots, tmp_path):
    result = fleet(robots / "broken", "--out", tmp_path)
    assert result.exit_code == 1
    assert "no robot has an answer" in result.stderr


def test_folder_without_recordings_is_wrong_use(tmp_path):
    result = fleet(tmp_path, "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert not (tmp_path / "out").exists()


def test_robots_are_told_apart_by_where_their_recordings_lie(tmp_path):
    for path in (
        "a/one.bag",
        "a/two.mcap",
        "b/monday/recording.yaml",
        "b/friday/recording.yaml",
        "c/notes.txt",
    ):
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).touch()
    found = {robot.name: len(robot.recordings) for robot in robots_in([tmp_path])}
    assert found == {"a": 2, "b": 2}
    (tmp_path / "d" / "run").mkdir(parents=True)
    (tmp_path / "d" / "run" / "manifest.yaml").write_text("format: fsm-calib/recording@1\n")
    assert [robot.recordings for robot in robots_in([tmp_path / "d"])] == [(tmp_path / "d" / "run",)]
    assert [robot.name for robot in robots_in([tmp_path / "a", tmp_path / "a"])] == ["a", "a-2"]
    assert [robot.name for robot in robots_in([tmp_path / "a" / "one.bag"])] == ["one"]
    with pytest.raises(InputError, match="no recording"):
        robots_in([tmp_path / "c"])


def test_robot_with_missing_physics_comes_before_one_that_pulls_more():
    fading = {"robot": "a", "straight": {"turned_rad": 0.01}, "diagnosis": {"verdict": "explained"}}
    pulling = {"robot": "b", "straight": {"turned_rad": 0.1}, "diagnosis": {"verdict": "match"}}
    assert sorted([pulling, fading], key=worst_first) == [fading, pulling]
