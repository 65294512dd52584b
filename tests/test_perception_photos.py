"""Real photos, and the command on them: two chessboard sets, a floor board, a turned tag, damaged input."""

import json
import math
import os
from pathlib import Path

import cv2
import numpy as np
import pytest
from camera_views import BOARD, hand_held
from typer.testing import CliRunner, Result

import fsm_calib
from fsm_calib.cli import app
from fsm_calib.perception.camera_files import read_intrinsics
from fsm_calib.perception.chessboard import inspect_board
from fsm_calib.perception.extrinsics import Extrinsics, calibrate_extrinsics
from fsm_calib.perception.ground import tag_poses
from fsm_calib.perception.tags import find_tags
from fsm_calib.types import BoardSpec, CameraModel

ROOT = Path(fsm_calib.__file__).parent.parent
PHOTOS = Path(os.environ.get("FSM_CALIB_SHARED", ROOT.parent / "shared")) / "photos"


def photos(folder: str, pattern: str) -> list[Path]:
    """Return real photos; skip the test where they are missing."""
    found = sorted((PHOTOS / folder).glob(pattern))
    if not found:
        pytest.skip(f"needs {folder} below FSM_CALIB_SHARED/photos")
    return found


def calibrate_camera(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["calibrate-camera", *map(str, arguments)])


@pytest.fixture
def drawn(tmp_path: Path) -> list[Path]:
    """Return five drawn photos of a 7x5 board, seen through the fleet's lens."""
    squares = np.add.outer(np.arange(6), np.arange(8)) % 2
    picture = cv2.copyMakeBorder(
        np.kron(255 * squares, np.ones((40, 40))).astype(np.uint8),
        40,
        40,
        40,
        40,
        cv2.BORDER_CONSTANT,
        value=255,
    )
    inner = 80.0 + 40.0 * np.mgrid[0:7, 0:5].T.reshape(-1, 2) - 0.5
    files = []
    for index, view in enumerate(hand_held(5, 0.0, seed=4)):
        place, _ = cv2.findHomography(inner, view.corners_image)
        image = cv2.warpPerspective(picture, place, (640, 480), borderValue=200.0, flags=cv2.INTER_AREA)
        files.append(tmp_path / f"photo{index}.png")
        cv2.imwrite(str(files[-1]), image)
    return files


def test_the_opencv_set_is_solved_with_four_coefficients(tmp_path: Path) -> None:
    out, camera_info = tmp_path / "camera.json", tmp_path / "camera.yaml"
    answer = calibrate_camera(
        *photos("opencv-left", "*.jpg"),
        "--board",
        "9x6",
        "--square",
        0.025,
        "--json",
        out,
        "--out",
        camera_info,
    )
    assert answer.exit_code == 0, answer.output
    camera = json.loads(out.read_text())
    assert camera["boards_found"] == camera["views_used"] == 13
    assert camera["rms_px"] <= 0.20
    assert camera["distortion"][4:] == [0.0]
    assert camera["views_dropped"] == []
    np.testing.assert_allclose(read_intrinsics(camera_info).matrix, camera["matrix"], rtol=1e-9)


def test_the_wide_set_gets_the_lens_that_views_left_out_prefer(tmp_path: Path) -> None:
    out = tmp_path / "camera.json"
    answer = calibrate_camera(*photos("gopro-wide-chessboard", "GOPR*.jpg"), "--board", "8x6", "--json", out)
    assert answer.exit_code == 0, answer.output
    camera = json.loads(out.read_text())
    assert camera["boards_found"] == 13
    assert camera["model"] == "equidistant"
    assert camera["cross_validated_px"] < 0.36  # cv2.fisheye's, see benchmarks/camera_peers.py


def ttic_floor_board(projection: np.ndarray) -> Extrinsics:
    """Return what the photo of the floor board gives; matrices by Duckietown's lib-dt-computer-vision."""
    path = photos("duckiebot-extrinsic", "ttic_board.jpg")[0]
    matrix = np.array([[295.796, 0.0, 321.262], [0.0, 299.539, 241.736], [0.0, 0.0, 1.0]])
    distortion = np.array([-0.235440, 0.036378, -0.003307, -0.001214, 0.0])
    camera = CameraModel(matrix, distortion, 640, 480, "plumb_bob")
    image = np.asarray(cv2.imread(str(path)), np.uint8)
    return calibrate_extrinsics(image, BoardSpec(7, 5, 0.031), camera, projection=projection)


TTIC_PROJECTION = np.array([[201.140, 0.0, 319.559], [0.0, 239.744, 237.602], [0.0, 0.0, 1.0]])


def test_a_duckiebots_floor_board_gives_its_height() -> None:
    found = ttic_floor_board(TTIC_PROJECTION)
    assert found.mount.height == pytest.approx(0.100, abs=0.005)


def test_the_principal_point_meets_the_floor_where_it_was_measured_and_where_duckietown_computes_it() -> None:
    found = ttic_floor_board(TTIC_PROJECTION)
    assert found.principal_point_reach == pytest.approx(0.40, abs=0.01)  # by hand, when the photo was taken
    published = 0.39335  # H (0, 0, 1) of the homography in that package's test_reprojection.py
    assert found.principal_point_reach == pytest.approx(published, abs=0.002)
    assert found.axis_reach == pytest.approx(0.4125, abs=0.002)


def test_the_two_points_are_one_where_rectifying_keeps_the_matrix() -> None:
    matrix = np.array([[295.796, 0.0, 321.262], [0.0, 299.539, 241.736], [0.0, 0.0, 1.0]])
    found = ttic_floor_board(matrix)
    assert found.principal_point_reach == pytest.approx(found.axis_reach, rel=1e-9)


def test_a_turned_tag_is_read_within_four_degrees_of_its_labels() -> None:
    matrix = np.array([[329.873, 0.0, 528.0], [0.0, 332.946, 396.0], [0.0, 0.0, 1.0]])
    camera = CameraModel(matrix, np.zeros(5), 1056, 792, "plumb_bob")
    labels, turns = range(-70, 70, 10), []
    for label in labels:
        path = photos("apriltag-duckietown", f"test_image_rotation_{label}.png")[0]
        (tag,) = find_tags(np.asarray(cv2.imread(str(path)), np.uint8))
        outward = tag_poses(tag, camera, 0.065)[0].rotation[:, 2]
        turns.append(math.degrees(math.atan2(outward[0], -outward[2])))
    errors = np.array(turns) - labels
    assert np.ptp(errors) < 8.0


def test_a_large_photo_is_measured_by_its_own_scale() -> None:
    board, path = BoardSpec(9, 6, 0.025), photos("opencv-left", "left01.jpg")[0]
    image = np.asarray(cv2.imread(str(path), cv2.IMREAD_GRAYSCALE), np.uint8)
    large = np.asarray(cv2.resize(image, None, fx=5, fy=5, interpolation=cv2.INTER_CUBIC), np.uint8)
    small, found = inspect_board(image, board), inspect_board(large, board)
    assert small.view is not None
    assert found.view is not None, found.refusal
    off = (found.view.corners_image + 0.5) / 5.0 - 0.5 - small.view.corners_image
    assert float(np.sqrt(np.mean(off**2))) < 0.1


def test_too_few_photos_are_refused(drawn: list[Path]) -> None:
    answer = calibrate_camera(*drawn[:4], "--board", "7x5")
    assert answer.exit_code == 1
    assert "4 views of the whole board are too few" in answer.output


def test_photos_of_another_board_are_refused_with_its_size(drawn: list[Path]) -> None:
    answer = calibrate_camera(*drawn, "--board", "9x4")
    assert answer.exit_code == 2
    assert f"{BOARD.columns}x{BOARD.rows}" in answer.output


def test_photos_without_a_board_are_refused(tmp_path: Path) -> None:
    empty = tmp_path / "empty.png"
    cv2.imwrite(str(empty), np.full((120, 160), 90, np.uint8))
    answer = calibrate_camera(empty, "--board", "9x6")
    assert answer.exit_code == 1
    assert "uniform" in answer.output


def test_one_photo_twice_is_refused(drawn: list[Path]) -> None:
    answer = calibrate_camera(drawn[0], drawn[1], drawn[0], "--board", "7x5")
    assert answer.exit_code == 2
    assert "same photo" in answer.output


def test_a_text_file_is_refused(drawn: list[Path], tmp_path: Path) -> None:
    text = tmp_path / "notes.jpg"
    text.write_text("no picture")
    answer = calibrate_camera(*drawn, text, "--board", "7x5")
    assert answer.exit_code == 2
    assert "is not an image" in answer.output


def test_photos_of_two_sizes_are_refused(drawn: list[Path], tmp_path: Path) -> None:
    small = tmp_path / "small.png"
    cv2.imwrite(str(small), np.full((120, 160), 90, np.uint8))
    answer = calibrate_camera(*drawn, small, "--board", "7x5")
    assert answer.exit_code == 2
    assert "160x120 px" in answer.output


@pytest.mark.parametrize("text", ["9by6", "2x2", "9x6x3"])
def test_a_board_that_is_none_is_refused(drawn: list[Path], text: str) -> None:
    answer = calibrate_camera(*drawn, "--board", text)
    assert answer.exit_code == 2


def test_two_boards_are_refused(drawn: list[Path]) -> None:
    answer = calibrate_camera(*drawn, "--board", "9x6", "--board", "8x6")
    assert answer.exit_code == 2
    assert "one board at a time" in answer.output


def test_a_file_that_cannot_be_written_is_refused_before_the_work(drawn: list[Path], tmp_path: Path) -> None:
    answer = calibrate_camera(*drawn, "--board", "7x5", "--json", tmp_path / "missing" / "camera.json")
    assert answer.exit_code == 2
    assert "no such folder" in answer.output
