"""`fsm-calib calibrate-extrinsics`: the mount from one photo of a floor board, told to a person and as files."""

import json
import math
from pathlib import Path

import cv2
import numpy as np
import pytest
from typer.testing import CliRunner, Result

from fsm_calib.cli import app
from fsm_calib.perception.camera_files import read_extrinsics, write_intrinsics
from fsm_calib.perception.extrinsics import FLOOR_BOARD_OFFSET, board_points_base, is_corrupt
from fsm_calib.types import BoardSpec, Pose2
from fsm_calib.world2d.camera import Renderer
from fsm_calib.world2d.fleet import nominal_robot
from fsm_calib.world2d.scene import BoardPlacement, SceneSpec
from fsm_calib.world2d.sensor import SensorSettings, expose
from fsm_calib.world2d.surfaces import build_scene

ROBOT, BOARD = nominal_robot(), BoardSpec()


def calibrate(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["calibrate-extrinsics", *map(str, arguments)])


@pytest.fixture(scope="module")
def floor(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Return a photo of a board at the default offset, and the file of the camera that took it."""
    folder, rng = tmp_path_factory.mktemp("floor"), np.random.default_rng(2)
    x, y, _ = board_points_base(BOARD, FLOOR_BOARD_OFFSET).mean(axis=0)
    placement = BoardPlacement(BOARD, x=float(x), y=float(y), yaw=math.pi, lean=math.pi / 2.0)
    light = Renderer(build_scene(SceneSpec(boards=(placement,)), rng), ROBOT.camera, ROBOT.mount).ideal(
        Pose2()
    )
    cv2.imwrite(str(folder / "board.png"), expose(light, ROBOT.camera, SensorSettings(), rng))
    return folder / "board.png", write_intrinsics(folder / "camera.yaml", ROBOT.camera, "camera")


def test_the_optical_axis_meets_the_floor_where_height_and_pitch_send_it(floor, tmp_path) -> None:
    photo, camera = floor
    answer = calibrate(photo, "--camera", camera, "--json", tmp_path / "found.json")
    assert answer.exit_code == 0, answer.output
    found = json.loads((tmp_path / "found.json").read_text())
    mount = ROBOT.mount
    assert found["axis_reach"] == pytest.approx(
        mount.forward + mount.height / math.tan(mount.pitch), abs=0.003
    )
    assert found["mount"]["height"] == pytest.approx(mount.height, abs=0.001)
    assert found["mount"]["pitch"] == pytest.approx(mount.pitch, abs=0.003)


def test_the_figure_for_a_tape_measure_comes_first_and_both_are_explained(floor, tmp_path) -> None:
    photo, camera = floor
    lines = calibrate(photo, "--camera", camera, "--json", tmp_path / "found.json").output.splitlines()
    found = json.loads((tmp_path / "found.json").read_text())
    assert lines[0].startswith(f"principal point     meets the floor {found['principal_point_reach']:.4f} m")
    assert lines[1].startswith(f"optical axis        meets the floor {found['axis_reach']:.4f} m")
    assert "(1) To compare with a tape measure" in "\n".join(lines)


def test_the_written_file_holds_the_homography(floor, tmp_path) -> None:
    photo, camera = floor
    out = tmp_path / "robot.yaml"
    assert (
        calibrate(photo, "--camera", camera, "--out", out, "--json", tmp_path / "found.json").exit_code == 0
    )
    homography = read_extrinsics(out)
    assert not is_corrupt(homography)
    assert homography == pytest.approx(
        np.array(json.loads((tmp_path / "found.json").read_text())["homography"])
    )


def test_a_photo_of_another_size_than_the_cameras_is_refused(floor, tmp_path) -> None:
    photo, camera = floor
    small = tmp_path / "small.png"
    cv2.imwrite(str(small), cv2.resize(cv2.imread(str(photo)), (320, 240)))
    answer = calibrate(small, "--camera", camera, "--out", tmp_path / "robot.yaml")
    assert answer.exit_code == 2
    assert "small.png: is 320x240 px, but the camera file is for 640x480 px" in answer.output
    assert not (tmp_path / "robot.yaml").exists()


def test_a_photo_without_a_board_fails_with_the_cure(floor, tmp_path) -> None:
    cv2.imwrite(str(tmp_path / "grey.png"), np.full((480, 640), 128, np.uint8))
    answer = calibrate(tmp_path / "grey.png", "--camera", floor[1])
    assert answer.exit_code == 1
    assert "Lay the board flat" in answer.output
