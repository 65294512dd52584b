"""Debian's `rosbag record` during a run: its bag opens, `identify` reads the drive, `diagnose` finds a match."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from ros_rig import NO_ROS, debian_master, until
from served_robot import served

from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.diagnosis.identify.identify import identify
from fsm_calib.recording.read import read_recording
from fsm_calib.robots.ros1.calls import Caller
from fsm_calib.robots.ros1.served_node import ServedNode
from fsm_calib.runner.run import run_scenario
from fsm_calib.scenario.load import scenario_from
from fsm_calib.scenario.yaml_source import parse_yaml

SCENARIO = """
name: recorded
seed: 5
robot: {source: nominal, wheel_ratio: 1.04, name: duckie}
plan: [orientation, wheels]
output: {report: false, recording: false, bag: none, frames: 0}
"""
RECORDED = (
    "/duckie/wheels_driver_node/wheels_cmd_executed",
    "/duckie/left_wheel_encoder_node/tick",
    "/duckie/right_wheel_encoder_node/tick",
    "/duckie/tracker/pose",
    "/duckie/fsm_calib/state",
)


@contextmanager
def recorded(url: str, bag: Path, node: ServedNode) -> Iterator[None]:
    """Record as an owner would, until the block ends; the recorder is connected to all that the robot publishes."""
    tools = {**os.environ, "ROS_MASTER_URI": url, "ROS_HOSTNAME": "127.0.0.1"}
    command = ["rosbag", "record", "-O", str(bag), *RECORDED]
    process = subprocess.Popen(
        command, env=tools, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
    )
    master = Caller(url, "the ROS master")

    def listens() -> bool:
        heard = {topic for topic, _ in master.call("getSystemState", "/test")[1]}
        publishers = node.node.publishers
        return set(RECORDED) <= heard and all(
            publishers[topic].listeners for topic in RECORDED if topic in publishers
        )

    try:
        until(listens, "rosbag listens")
        yield
    finally:
        os.killpg(process.pid, signal.SIGINT)
        process.wait()


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if shutil.which("rosbag") is None:
        pytest.skip(NO_ROS)
    folder = tmp_path_factory.mktemp("recorded")
    path = folder / "run.bag"
    scenario = scenario_from(parse_yaml(SCENARIO))
    with (
        debian_master() as url,
        served(scenario, url, tracker=25.0) as (node, client),
        recorded(url, path, node),
    ):
        assert run_scenario(client, folder / "run").result["outcome"] == "done"
    until(path.exists, "rosbag closes its file")
    return path


@pytest.mark.slow
def test_a_bag_recorded_during_a_run_opens_in_rosbag_info(bag: Path) -> None:
    said = subprocess.run(["rosbag", "info", str(bag)], capture_output=True, text=True, check=True).stdout
    assert all(topic in said for topic in RECORDED)


def test_identify_reads_the_run_from_the_bag(bag: Path) -> None:
    recording = read_recording(bag)
    assert recording.pose is not None
    assert recording.command is not None
    assert recording.wheel_angle is not None
    assert any("wheels/" in path for path in recording.state.path)
    found = identify([recording])
    left, right = found.value("wheel_gain_left"), found.value("wheel_gain_right")
    assert left is not None
    assert right is not None
    assert left / right == pytest.approx(1.04, abs=0.01)


def test_the_encoders_of_the_bag_agree_with_its_poses(bag: Path) -> None:
    found = identify([read_recording(bag)])
    axle, ahead, aside = (found.value(name) for name in ("axle_length", "sensor.x", "sensor.y"))
    assert axle == pytest.approx(0.1, abs=0.01)
    assert ahead == pytest.approx(0.0, abs=0.003)
    assert aside == pytest.approx(0.0, abs=0.003)


@pytest.mark.slow
def test_the_served_robot_is_a_match_to_the_simulation(bag: Path) -> None:
    found = diagnose([read_recording(bag).window(0.0, 40.0)], seed=1)
    assert found.verdict.verdict == "match"
