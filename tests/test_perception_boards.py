"""Boards of other kinds, whole and in part, drawn by their makers' rules and seen by a known camera; bent boards."""

import json

import cv2
import numpy as np
import pytest
from camera_views import BOARD, SIZE, TRUTH, hand_held
from typer.testing import CliRunner

from fsm_calib.cli import app
from fsm_calib.perception.board_warp import BoardWarp, warped
from fsm_calib.perception.camera_files import read_intrinsics
from fsm_calib.perception.camera_formats import kalibr_text, opencv_text
from fsm_calib.perception.grid_boards import BoardRequest
from fsm_calib.perception.intrinsics import calibrate
from fsm_calib.perception.lens import project
from fsm_calib.perception.rotations import rotation_from_vector
from fsm_calib.perception.tags import tag_cells
from fsm_calib.types import BoardView, CameraModel

MATRIX = np.array([[520.0, 0.0, 318.0], [0.0, 524.0, 243.0], [0.0, 0.0, 1.0]])
SQUARE = 0.03
SCALE = 2000.0  # px/m of the drawings
BORDER = 60  # px
KALIBR_CODES = {0: 0xD5D628584, 1: 0xD97F18B49, 11: 0x3FF962CD5}
"""Codes of tag36h11 as Kalibr's generator lists them, the upper left cell in the highest bit, a 1 is white.

Source: github.com/ethz-asl/kalibr, aslam_offline_calibration/kalibr/python/kalibr_create_target_pdf.
"""


def drawn_charuco() -> np.ndarray:
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_1000)
    board = cv2.aruco.CharucoBoard((8, 6), SQUARE, 0.75 * SQUARE, dictionary)
    return board.generateImage((round(8 * SQUARE * SCALE), round(6 * SQUARE * SCALE)))


def drawn_aprilgrid() -> np.ndarray:
    """Draw a grid of 4x3 tags as Kalibr does: numbers from the lower left, two cells of border, squares in the gaps.

    The rules are those of Kalibr's generator, `generateAprilBoard` and `generateAprilTag` (see `KALIBR_CODES`): tag
    `columns * y + x` lies at `(x, y) (1 + spacing) size`, y up; `borderBits=2`; a black square of `spacing * size` at
    each tag's four corners (`symmCorners`).
    """
    cell = round(SQUARE * SCALE) // 10
    tag, gap = 10 * cell, 3 * cell
    width, height = 4 * tag + 5 * gap, 3 * tag + 4 * gap
    image = np.full((height, width), 255, dtype=np.uint8)
    for row in range(4):
        for column in range(5):
            y, x = row * (tag + gap), column * (tag + gap)
            image[y : y + gap, x : x + gap] = 0
    for number in range(12):
        row, column = 2 - number // 4, number % 4
        dark = np.pad(tag_cells(number), 1, constant_values=True)
        y, x = gap + row * (tag + gap), gap + column * (tag + gap)
        image[y : y + tag, x : x + tag] = np.kron(np.where(dark, 0, 255), np.ones((cell, cell)))
    return image


def drawn_circles(request: BoardRequest) -> np.ndarray:
    points = request.spec().points_board()[:, :2] * SCALE
    image = np.full((points.max(axis=0)[::-1] + 120).astype(int), 255, dtype=np.uint8)
    for x, y in points:
        centre = tuple(int(v) for v in np.round((np.array([x, y]) + 60) * 16))
        cv2.circle(image, centre, round(0.3 * request.square * SCALE * 16), 0, -1, cv2.LINE_AA, shift=4)
    return image


ASIDE = {"charuco": 0.26, "aprilgrid": 0.2}
"""So far out of the middle, the board is cut by the image's border [m]."""
CHARUCO = BoardRequest("charuco", 8, 6, SQUARE)
APRILGRID = BoardRequest("aprilgrid", 4, 3, SQUARE)
CIRCLES = BoardRequest("circles", 7, 5, SQUARE)
ASYMMETRIC = BoardRequest("asymmetric_circles", 4, 9, 0.02)
#: request, drawing, where the first point lies in it [px]; pixel centres are whole numbers
KINDS = {
    "charuco": (CHARUCO, drawn_charuco(), SQUARE * SCALE - 0.5),
    "aprilgrid": (APRILGRID, drawn_aprilgrid(), 0.3 * SQUARE * SCALE - 0.5),
    "circles": (CIRCLES, drawn_circles(CIRCLES), 60.0),
    "asymmetric_circles": (ASYMMETRIC, drawn_circles(ASYMMETRIC), 60.0),
}


def seen(kind, seed, aside=0.0):
    """Return a picture of a board by the pinhole camera, and where its points are in it [px]."""
    request, picture, first = KINDS[kind]
    rng = np.random.default_rng(seed)
    points = request.spec().points_board()
    middle = points.mean(axis=0)
    turn = rotation_from_vector(rng.uniform(-0.5, 0.5, 3))
    place = np.array([*rng.uniform(-0.03, 0.03, 2), rng.uniform(0.38, 0.6)])
    place[0] += aside
    camera = (points - middle) @ turn.T + place
    image = (camera / camera[:, 2:]) @ MATRIX.T
    scaled = points[:, :2] * SCALE + first
    homography, _ = cv2.findHomography(scaled, image[:, :2])
    padded = cv2.copyMakeBorder(picture, BORDER, BORDER, BORDER, BORDER, cv2.BORDER_CONSTANT, value=255)
    shifted = homography @ np.array([[1.0, 0.0, -BORDER], [0.0, 1.0, -BORDER], [0.0, 0.0, 1.0]])
    big = (
        np.diag([3.0, 3.0, 1.0])
        @ np.array([[1.0, 0.0, 1.0 / 3.0], [0.0, 1.0, 1.0 / 3.0], [0.0, 0.0, 1.0]])
        @ shifted
    )
    fine = cv2.warpPerspective(padded, big, (3 * SIZE[0], 3 * SIZE[1]), borderValue=255.0)
    return cv2.GaussianBlur(cv2.resize(fine, SIZE, interpolation=cv2.INTER_AREA), (0, 0), 0.6), image[:, :2]


@pytest.mark.parametrize("kind", list(KINDS))
def test_whole_board_is_found_in_order_to_a_fraction_of_a_pixel(kind) -> None:
    find = KINDS[kind][0].finder()
    for seed in range(3):
        image, truth = seen(kind, seed)
        view = find(image).view
        assert view is not None
        off = np.linalg.norm(view.corners_image - truth, axis=1)
        assert np.nanmedian(off) < 0.2
        assert np.nanmax(off) < 0.8
        assert np.isfinite(off).mean() > 0.9


@pytest.mark.parametrize("kind", ["charuco", "aprilgrid"])
def test_part_of_a_board_is_used_and_the_rest_is_unknown(kind) -> None:
    image, truth = seen(kind, 1, aside=ASIDE[kind])
    view = KINDS[kind][0].finder()(image).view
    assert view is not None
    known = np.isfinite(view.corners_image[:, 0])
    assert 8 <= known.sum() < len(truth)
    assert np.linalg.norm(view.corners_image - truth, axis=1)[known].max() < 0.8


@pytest.mark.parametrize("kind", list(KINDS))
def test_missing_board_is_refused_with_a_reason(kind) -> None:
    finding = KINDS[kind][0].finder()(np.full((480, 640), 128, dtype=np.uint8))
    assert finding.view is None
    assert "found" in finding.refusal


def test_partial_views_give_the_same_camera_as_whole_ones() -> None:
    views = hand_held(14, 0.1, seed=2)
    rng = np.random.default_rng(0)
    cut = []
    for view in views:
        corners = view.corners_image.copy()
        corners[rng.permutation(len(corners))[:12]] = np.nan
        cut.append(BoardView(corners, source=view.source))
    found = calibrate(cut, BOARD, SIZE)
    assert not found.views_dropped
    assert np.abs(found.camera.matrix[:2] - [[TRUTH[0], 0, TRUTH[2]], [0, TRUTH[1], TRUTH[3]]]).max() < 2.0
    assert found.rms_px == pytest.approx(0.14, rel=0.15)


def test_bend_of_a_board_is_found_and_the_lens_spared() -> None:
    bend = BoardWarp(0.0015, -0.0008)
    points, flat = warped(BOARD.points_board(), bend), BOARD.points_board()
    rng = np.random.default_rng(5)
    views = []
    while len(views) < 20:
        turn = rotation_from_vector(rng.uniform(-0.6, 0.6, 3))
        camera = (points - flat.mean(axis=0)) @ turn.T + rng.uniform(0.22, 0.45) * np.array(
            [*rng.uniform(-0.7, 0.7, 2), 1.0]
        )
        image = project(TRUTH, camera)
        if np.all((image > 5) & (image < np.array(SIZE) - 6)):
            views.append(BoardView(image + rng.normal(size=image.shape) * 0.05))
    found = calibrate(views, BOARD, SIZE, may_be_bent=True)
    assert found.board_warp is not None
    assert found.board_warp.across == pytest.approx(bend.across, abs=1e-4)
    assert found.board_warp.along == pytest.approx(bend.along, abs=1e-4)
    assert found.cross_validated_px < 0.7 * calibrate(views, BOARD, SIZE).cross_validated_px


def test_flat_board_is_left_flat() -> None:
    assert calibrate(hand_held(15, 0.1, seed=7), BOARD, SIZE, may_be_bent=True).board_warp is None


def run(*arguments: object):
    return CliRunner().invoke(app, ["calibrate-camera", *map(str, arguments)])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("photos")
    for seed in range(10):
        cv2.imwrite(str(place / f"photo{seed}.png"), seen("charuco", seed, aside=0.02 * seed - 0.1)[0])
    return place


def test_folder_of_photos_calibrates_and_tells_each_photo(folder, tmp_path) -> None:
    file = tmp_path / "camera.yaml"
    done = run(
        folder, "--kind", "charuco", "--board", "8x6", "--square", SQUARE, "--json", "-", "--out", file
    )
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    assert told["matrix"][0][0] == pytest.approx(520.0, abs=6.0)
    assert [view["file"] for view in told["views"]] == sorted(str(path) for path in folder.iterdir())
    assert read_intrinsics(file).matrix[0, 0] == told["matrix"][0][0]


def test_video_is_input_and_its_frames_are_named(tmp_path) -> None:
    name = tmp_path / "walk.avi"
    video = cv2.VideoWriter(str(name), cv2.VideoWriter_fourcc(*"MJPG"), 10, SIZE)
    if not video.isOpened():
        pytest.skip("this OpenCV writes no video")
    for seed in range(7):
        image = cv2.cvtColor(seen("charuco", seed, aside=0.02 * seed - 0.1)[0], cv2.COLOR_GRAY2BGR)
        for _ in range(2):  # a frame that shows nothing new is no view
            video.write(image)
    video.release()
    done = run(name, "--kind", "charuco", "--board", "8x6", "--square", SQUARE, "--json", "-")
    assert done.exit_code in (0, 1), done.output
    told = json.loads(done.stdout)
    assert told["boards_found"] == 7
    assert told["views"][0]["file"].startswith(f"{name}#")


def test_folder_without_photos_is_refused(tmp_path) -> None:
    done = run(tmp_path, "--board", "8x6")
    assert done.exit_code == 2
    assert "holds no photo" in done.output


def test_two_cameras_are_compared_over_the_image(tmp_path) -> None:
    from fsm_calib.perception.camera_files import write_intrinsics

    for name, focal in (("a", 500.0), ("b", 510.0)):
        matrix = np.array([[focal, 0, 320], [0, focal, 240], [0, 0, 1.0]])
        write_intrinsics(tmp_path / f"{name}.yaml", CameraModel(matrix, np.zeros(5)), name)
    done = run("--compare", tmp_path / "a.yaml", tmp_path / "b.yaml")
    assert done.exit_code == 0, done.output
    assert "differ by" in done.output
    same = run("--compare", tmp_path / "a.yaml", tmp_path / "a.yaml")
    assert "rms 0.00 px" in same.output


def test_comparison_is_written_as_json_and_as_a_page(tmp_path) -> None:
    from fsm_calib.perception.camera_files import write_intrinsics

    for name, focal in (("a", 500.0), ("b", 510.0)):
        matrix = np.array([[focal, 0, 320], [0, focal, 240], [0, 0, 1.0]])
        write_intrinsics(tmp_path / f"{name}.yaml", CameraModel(matrix, np.zeros(5)), name)
    pair = ("--compare", tmp_path / "a.yaml", tmp_path / "b.yaml")
    done = run(*pair, "--json", "-", "--report", tmp_path / "apart.html")
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    assert 0.0 < told["median_px"] <= told["max_px"]
    assert np.sqrt(np.mean(np.square(told["over_the_image_px"]))) == pytest.approx(told["rms_px"])
    assert "Difference of two cameras over the image" in (tmp_path / "apart.html").read_text()
    nowhere = run(*pair, "--report", tmp_path / "missing" / "apart.html")
    assert nowhere.exit_code == 2
    assert "no such folder" in nowhere.output


def test_opencv_reads_what_is_written_for_it(tmp_path) -> None:
    camera = CameraModel(MATRIX, np.array([-0.3, 0.1, 1e-3, 0.0, 0.02]))
    (tmp_path / "camera.yaml").write_text(opencv_text(camera, "camera", "a remark"))
    file = cv2.FileStorage(str(tmp_path / "camera.yaml"), cv2.FILE_STORAGE_READ)
    np.testing.assert_array_equal(file.getNode("camera_matrix").mat(), camera.matrix)
    np.testing.assert_array_equal(file.getNode("distortion_coefficients").mat().ravel(), camera.distortion)


def test_kalibr_gets_radtan_and_nothing_that_it_has_not() -> None:
    import yaml

    from fsm_calib.errors import DataError

    held = yaml.safe_load(kalibr_text(CameraModel(MATRIX, np.array([-0.3, 0.1, 1e-3, 0.0, 0.0])), "cam"))
    assert held["cam0"]["intrinsics"] == [520.0, 524.0, 318.0, 243.0]
    assert held["cam0"]["distortion_coeffs"] == [-0.3, 0.1, 1e-3, 0.0]
    with pytest.raises(DataError, match="--coefficients 4"):
        kalibr_text(CameraModel(MATRIX, np.array([-0.3, 0.1, 1e-3, 0.0, 0.02])), "cam")


@pytest.mark.parametrize(
    "wrong", [("--kind", "photo"), ("--gap", "-1"), ("--coefficients", "6"),
              ("--out", "camera.yaml", "--format", "word"), ("--kind", "charuco", "--dictionary", "DICT_9")]
)  # fmt: skip
def test_wrong_option_is_refused_before_any_work(folder, wrong) -> None:
    done = run(folder, "--board", "8x6", *wrong)
    assert done.exit_code == 2
    assert wrong[-2] in done.output


@pytest.mark.parametrize("number", KALIBR_CODES)
def test_tag_has_the_cells_that_kalibrs_generator_draws(number) -> None:
    white = np.array([digit == "1" for digit in f"{KALIBR_CODES[number]:036b}"]).reshape(6, 6)
    np.testing.assert_array_equal(tag_cells(number), np.pad(~white, 1, constant_values=True))
