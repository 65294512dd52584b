"""An investigation of a served robot through ROS 1 in lockstep: by its own camera, late and lost frames, no truth."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from ros_rig import small_master
from served_robot import served
from typer.testing import CliRunner

from fsm_calib.cli import app
from fsm_calib.perception.camera_files import write_extrinsics, write_intrinsics
from fsm_calib.perception.extrinsics import floor_homography, rectified_matrix
from fsm_calib.scenario.load import load_scenario
from fsm_calib.types import STOP
from fsm_calib.world2d.truth import Truth

SCENARIO = """
name: served
seed: 3
robot:
  source: nominal
  wheel_ratio: 1.06
  name: duckie
  start: {x: -0.9, y: 0.0, theta: 0.5}
  effects: {motor_deadband: {offset: 0.24}}
  link: {lockstep: true}
investigate: {budget: 120, poses: camera, centre_x: -0.9, width: 1.7, depth: 1.4, command: 0.4, look_every: 0.2}
"""


def write_camera(truth: Truth, folder: Path) -> Path:
    """Write the camera as an earlier run would have found it, its tilt and yaw a little wrong."""
    mount = dataclasses.replace(truth.mount, pitch=truth.mount.pitch + 0.001, yaw=truth.mount.yaw + 0.005)
    homography = floor_homography(mount, rectified_matrix(truth.camera))
    write_intrinsics(folder / "camera_intrinsic" / "duckie.yaml", truth.camera, "duckie")
    write_extrinsics(folder / "camera_extrinsic" / "duckie.yaml", homography, "2026-01-01")
    return folder


@pytest.fixture(scope="module")
def investigated(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[dict[str, Any], Any, str]]:
    """The command line's own investigation of a served robot: its result, the node, and what was printed."""
    folder = tmp_path_factory.mktemp("served")
    path = folder / "served.yaml"
    path.write_text(SCENARIO)
    with (
        small_master() as master,
        served(load_scenario(path), master, dropped=0.1, late=0.05) as (node, _),
    ):
        camera = write_camera(node.robot.world.truth, folder / "camera")
        address = master.replace("http", "ros1") + "duckie"
        arguments = ("investigate", path, "--robot", address, "--calibration", camera, "--yes", "--out")
        said = CliRunner().invoke(app, [*map(str, arguments), str(folder / "out")])
        yield json.loads((folder / "out" / "investigation.json").read_text()), node, said.stdout


@pytest.mark.slow
def test_a_served_robot_finds_out_by_driving_what_its_motors_lose(investigated: Any) -> None:
    result, _, _ = investigated
    assert result["ended"] == "done"
    assert [effect["name"] for effect in result["effects"]] == ["motor_deadband"]
    sizes = result["effects"][0]["parameters"]
    assert sizes.keys() in (
        {"offset"},
        {"offset_left", "offset_right"},
    )  # one of both wheels, or each its own
    assert all(s["value"] == pytest.approx(0.24, abs=max(0.01, 3.0 * s["sd"])) for s in sizes.values())


def test_the_answer_is_printed_with_every_drive(investigated: Any) -> None:
    result, _, said = investigated
    assert said.startswith("done after")
    assert all(f"drive {number}: " in said for number in range(1, len(result["drives"]) + 1))


def test_the_served_robot_stays_in_its_area_and_stands_at_the_end(investigated: Any) -> None:
    _, node, _ = investigated
    x, y = node.robot.world.truth.trace[:, 1:3].T
    assert abs(x + 0.9).max() < 0.85
    assert abs(y).max() < 0.7
    assert node.last_received == STOP
