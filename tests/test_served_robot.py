"""A calibration through ROS 1: a served robot in lockstep, late and lost frames, whole PWM numbers, no truth."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from ros_rig import small_master, until
from served_robot import served

from fsm_calib.errors import InputError, LinkLost
from fsm_calib.outcome import Outcome
from fsm_calib.perception.prediction import projection_difference
from fsm_calib.robots.ros1.messages import MODE, TEXT, message_type
from fsm_calib.robots.ros1.node import Node
from fsm_calib.robots.served.duckiebot import ServedDuckiebot
from fsm_calib.robots.served.settings import ServeSettings
from fsm_calib.robots.served.station import LARGEST_CHUNK, Station
from fsm_calib.runner.connecting import with_robot
from fsm_calib.runner.progress import Silent
from fsm_calib.runner.run import run_scenario
from fsm_calib.scenario.load import load_scenario, scenario_from
from fsm_calib.scenario.models import Scenario
from fsm_calib.scenario.yaml_source import parse_yaml
from fsm_calib.types import STOP, Pose2, WheelCalibration, WheelCommand
from fsm_calib.world2d.deviation import straight_deviation
from fsm_calib.world2d.robot import WorldSpec, make_world
from fsm_calib.world2d.scene import SceneSpec

LOSSES = {"dropped": 0.1, "late": 0.05}
WHEELS = """
name: wheels
seed: 3
robot: {source: nominal, wheel_ratio: 1.05}
plan: [orientation, wheels]
output: {report: false, recording: true, bag: none, frames: 4}
"""


def scenario(text: str = WHEELS) -> Scenario:
    return scenario_from(parse_yaml(text))


@pytest.fixture(scope="module")
def master() -> Iterator[str]:
    with small_master() as url:
        yield url


class Kept:
    """An outlet that keeps what a served robot publishes."""

    def __init__(self) -> None:
        self.frames: list[tuple[int, float]] = []
        self.applied: list[tuple[WheelCommand, float]] = []
        self.counts = {"left": 0, "right": 0}
        self.poses: list[tuple[Pose2, float]] = []

    def frame(self, number: int, stamp: float, image: np.ndarray) -> None:
        self.frames.append((number, stamp))

    def executed(self, command: WheelCommand, number: int, time: float) -> None:
        self.applied.append((command, time))

    def ticks(self, side: str, count: int, time: float) -> None:
        self.counts[side] = count

    def tracked(self, pose: Pose2, time: float) -> None:
        self.poses.append((pose, time))


def duckiebot(*, watched: bool = False, **settings: float) -> tuple[ServedDuckiebot, Kept]:
    kept = Kept()
    robot = ServedDuckiebot(make_world(WorldSpec(scene=SceneSpec())), ServeSettings(**settings), kept)
    robot.is_watched = watched
    return robot, kept


def test_frames_are_stamped_after_their_latency_and_some_never_come() -> None:
    robot, kept = duckiebot(watched=True, camera_latency=0.1, camera_jitter=0.0, dropped=0.5)
    robot.run_until(0.6)
    assert 2 < len(kept.frames) < 13
    assert all(stamp == pytest.approx(number / 30.0 + 0.1, abs=0.003) for number, stamp in kept.frames)


def test_late_frames_come_after_newer_ones() -> None:
    robot, kept = duckiebot(watched=True, late=0.3)
    robot.run_until(0.6)
    numbers = [number for number, _ in kept.frames]
    assert numbers != sorted(numbers)


def test_commands_act_after_the_drivers_delay_and_in_their_order() -> None:
    robot, kept = duckiebot(command_latency=0.05, command_jitter=0.03)
    robot.run_until(0.5)
    for number in range(5):
        robot.take(WheelCommand(0.1 * number, 0.0))
    robot.run_until(1.0)
    assert [round(command.left, 1) for command, _ in kept.applied] == [0.0, 0.1, 0.2, 0.3, 0.4]
    assert all(time > 0.5 for _, time in kept.applied[1:])


def test_a_driver_without_a_watch_turns_the_wheels_for_ever_and_encoders_count_it() -> None:
    robot, kept = duckiebot()
    robot.take(WheelCommand(0.2, 0.2))
    robot.run_until(2.0)
    half = kept.counts["left"]
    robot.run_until(4.0)
    assert kept.counts["left"] > 1.9 * half > 0
    turns = robot.world.truth.odometer / (2.0 * np.pi * WheelCalibration().wheel_radius)
    assert kept.counts["left"] == pytest.approx(135 * turns, rel=0.05)


def test_encoders_count_forward_what_rolls_out_backwards() -> None:
    robot, kept = duckiebot()
    robot.take(WheelCommand(-0.4, -0.4))
    robot.run_until(1.0)
    robot.take(WheelCommand())
    robot.run_until(1.01)
    begin = kept.counts["left"]
    robot.run_until(2.0)
    assert begin < 0
    assert kept.counts["left"] > begin


def test_a_tracker_tells_where_the_robot_is_with_its_noise() -> None:
    robot, kept = duckiebot(tracker=20.0, tracker_noise=0.01)
    robot.run_until(2.0)
    truth = robot.world.truth.pose
    assert len(kept.poses) == 41
    assert np.std([pose.x - truth.x for pose, _ in kept.poses]) == pytest.approx(0.01, rel=0.4)


def test_the_emergency_stop_acts_at_the_next_command() -> None:
    robot, kept = duckiebot()
    robot.take(WheelCommand(0.2, 0.2))
    robot.run_until(0.5)
    robot.is_stopped = True
    robot.take(WheelCommand(0.2, 0.2))
    robot.run_until(1.0)
    assert kept.applied[-1][0] == STOP


def test_a_robot_in_real_time_leaves_out_what_the_machine_could_not_do_in_time() -> None:
    station = Station(make_world(WorldSpec()), ServeSettings(), Kept(), lockstep=False)
    station.follow(0.02)
    station.follow(5.0)
    assert station.robot.now == pytest.approx(0.02 + LARGEST_CHUNK, abs=0.003)
    assert station.stood + station.robot.now == pytest.approx(5.0, abs=0.003)
    station.follow(5.04)
    assert station.robot.now == pytest.approx(0.06 + LARGEST_CHUNK, abs=0.003)


class Cut(Silent):
    """Loses the robot after some events of a phase."""

    def __init__(self, phase: str, events: int) -> None:
        self.phase, self.left = phase, events

    def event(self, state: str, phase: str, outcome: Outcome | None, time: float) -> None:
        self.left -= state.startswith(self.phase)
        if self.left == 0:
            raise LinkLost("The cable is out")


def test_a_lost_wheels_run_resumes_with_its_phase_and_is_stored_on_the_robot(
    master: str, tmp_path: Path
) -> None:
    heard: list[bytes] = []
    modes: list[bytes] = []
    with served(scenario(), master, **LOSSES) as (node, client):
        listener = Node("/listener", master)
        listener.subscribe("/duckie/fsm_calib/state", TEXT, heard.append)
        listener.subscribe("/duckie/fsm_calib/mode", MODE, modes.append)
        with pytest.raises(LinkLost):
            run_scenario(client, tmp_path, observer=Cut("wheels", 4))
        assert node.last_received == STOP
        finished = run_scenario(client, tmp_path, resume=True)
        until(
            lambda: modes and any("done" in message_type(TEXT).decode(body).data for body in heard),
            "mode and end are told",
        )
        assert "CALIBRATING" in message_type(MODE).decode(modes[0]).state
        listener.close()
        result, truth = finished.result, node.robot.world.truth
        assert result["outcome"] == "done", result
        assert node.last_received == STOP
        assert abs(straight_deviation(truth.parameters, result["wheels"]["wheel_ratio"])) < 0.10
        trim = (result["wheels"]["wheel_ratio"] - 1.0) / (result["wheels"]["wheel_ratio"] + 1.0)
        assert node.saved["kinematics"]["trim"] == pytest.approx(trim)
    text = (tmp_path / "result.json").read_text()
    assert "true_" not in text
    assert result["wheels"]["wheel_ratio_error"] < 0.005
    assert result["distance_m"] > 1.0
    lines = (tmp_path / "journal.jsonl").read_text().splitlines()
    phases = [json.loads(line)["path"].split("/")[0] for line in lines]
    assert "orientation" not in phases[phases.index("wheels") :]


def test_a_real_robots_camera_is_never_taken_from_the_simulations_truth(tmp_path: Path) -> None:
    known = scenario(WHEELS.replace("wheel_ratio: 1.05", "known: {camera: true}"))
    with pytest.raises(InputError, match="truth"):
        run_scenario(with_robot(known, "ros1://127.0.0.1:1/duckie"), tmp_path)


@pytest.mark.slow
def test_a_full_calibration_through_the_network_is_as_good_as_a_simulated_one(
    master: str, tmp_path: Path
) -> None:
    full = load_scenario(Path(__file__).parents[1] / "scenarios" / "full_calibration.yaml")
    full = full.model_copy(update={"output": full.output.model_copy(update={"report": False})})
    with served(full, master, **LOSSES) as (node, client):
        finished = run_scenario(client, tmp_path)
        notebook, truth = finished.session.run.bench.notebook, node.robot.world.truth
        assert finished.result["outcome"] == "done", finished.result
        assert projection_difference(notebook.camera, truth.camera).rms < 0.6
        assert abs(straight_deviation(truth.parameters, notebook.wheel_ratio)) < 0.10
        assert node.saved["camera"].width == 640
