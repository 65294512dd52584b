"""The equidistant lens of a fisheye: the same as OpenCV's, chosen where photos left out agree, written for others."""

import cv2
import numpy as np
import pytest
import yaml

from fsm_calib.perception.camera_files import read_intrinsics, write_intrinsics
from fsm_calib.perception.camera_formats import kalibr_text, opencv_text
from fsm_calib.perception.fisheye import equidistant_like
from fsm_calib.perception.intrinsics import calibrate
from fsm_calib.perception.lens import (
    camera_model,
    intrinsics_vector,
    is_sane_over_image,
    project,
    project_with_derivatives,
    unproject,
)
from fsm_calib.perception.rotations import rotation_from_vector
from fsm_calib.perception.solve_settings import ANY_CAMERA
from fsm_calib.perception.undistort import undistorted
from fsm_calib.types import BoardSpec, BoardView, CameraModel

SIZE = (640, 480)
LENS = np.array([285.0, 284.0, 322.0, 238.0, -0.02, 0.006, -0.004, 0.0007])
BROWN = np.array([330.0, 331.0, 322.0, 238.0, -0.3, 0.09, 0.0004, -0.0003, 0.0, 0.0, 0.0, 0.0])
BOARD = BoardSpec(8, 6, 0.03)


def points(count=200, seed=0):
    """Return points [m] up to 65 degrees off the axis."""
    rng = np.random.default_rng(seed)
    r, way = np.tan(np.radians(rng.uniform(0.0, 65.0, count))), rng.uniform(0.0, 2.0 * np.pi, count)
    depth = rng.uniform(0.3, 2.0, count)
    return np.column_stack([r * np.cos(way), r * np.sin(way), np.ones(count)]) * depth[:, None]


def views(lens, count=18, noise=0.1, seed=1):
    """Return views of a board that fills the image's corners, with noise [px]."""
    rng, found = np.random.default_rng(seed), []
    grid = BOARD.points_board() - BOARD.points_board().mean(axis=0)
    while len(found) < count:
        turn = rotation_from_vector(rng.normal(size=3) * 0.35)
        away = np.array([*rng.uniform(-0.35, 0.35, 2), rng.uniform(0.12, 0.3)])
        seen = grid @ turn.T + away
        if seen[:, 2].min() < 0.05:
            continue
        image = project(lens, seen)
        inside = np.all((image > 3.0) & (image < np.array(SIZE) - 4.0), axis=1)
        if inside.sum() > 30:
            image = image + noise * rng.normal(size=image.shape)
            image[~inside] = np.nan
            found.append(BoardView(image, source=f"photo {len(found)}"))
    return found


def test_points_are_seen_where_opencv_sees_them():
    seen = points()
    matrix = camera_model(LENS, SIZE).matrix
    expected, _ = cv2.fisheye.projectPoints(seen[:, None], np.zeros(3), np.zeros(3), matrix, LENS[4:])
    assert project(LENS, seen) == pytest.approx(expected[:, 0], abs=1e-9)


def test_rays_come_back_from_the_image():
    seen = points()
    assert unproject(LENS, project(LENS, seen)) == pytest.approx(seen[:, :2] / seen[:, 2:], abs=1e-7)


def test_a_point_on_the_axis_is_seen_at_the_principal_point():
    image, by_point, _ = project_with_derivatives(LENS, np.array([[0.0, 0.0, 1.0]]))
    assert image[0] == pytest.approx(LENS[2:4])
    assert by_point[0, :, :2] == pytest.approx(np.diag(LENS[:2]))


def test_derivatives_are_those_of_small_steps():
    seen = points(20)
    image, by_point, by_lens = project_with_derivatives(LENS, seen)
    for k in range(3):
        moved = seen + 1e-6 * np.eye(3)[k]
        assert (project(LENS, moved) - image) / 1e-6 == pytest.approx(by_point[..., k], rel=1e-3, abs=1e-2)
    for k, step in enumerate([1e-4] * 4 + [1e-7] * 4):
        moved = LENS + step * np.eye(8)[k]
        assert (project(moved, seen) - image) / step == pytest.approx(by_lens[..., k], rel=1e-4, abs=1e-3)


def test_a_vector_and_its_camera_are_the_same_lens():
    camera = camera_model(LENS, SIZE)
    assert (camera.model, camera.distortion.tolist()) == ("equidistant", LENS[4:].tolist())
    assert intrinsics_vector(camera) == pytest.approx(LENS)
    assert is_sane_over_image(LENS, SIZE)


def test_an_equidistant_lens_is_started_from_another_lens_that_sees_alike():
    like = equidistant_like(BROWN, SIZE)
    rays = np.column_stack(
        [unproject(BROWN, np.array([[40.0, 240.0], [320.0, 20.0], [560.0, 420.0]])), np.ones(3)]
    )
    assert project(like, rays) == pytest.approx(project(BROWN, rays), abs=1.0)


@pytest.fixture(scope="module")
def fisheye():
    return calibrate(views(LENS), BOARD, SIZE, settings=ANY_CAMERA)


def test_a_fisheyes_photos_choose_the_equidistant_lens(fisheye):
    assert fisheye.camera.model == "equidistant"
    assert not fisheye.refused
    assert fisheye.models[-1].name == "the equidistant lens"
    assert fisheye.rms_px == pytest.approx(0.1 * np.sqrt(2.0), rel=0.1)


def test_a_fisheyes_numbers_are_found_within_their_deviations(fisheye):
    found = intrinsics_vector(fisheye.camera)
    deviation = fisheye.parameter_deviation
    for name, value, true in zip(deviation, found, LENS, strict=True):
        assert abs(value - true) < 4.0 * deviation[name], name


def test_photos_of_a_usual_lens_choose_no_fisheye():
    found = calibrate(views(BROWN, noise=0.1), BOARD, SIZE, settings=ANY_CAMERA)
    assert found.camera.model == "plumb_bob"


def test_a_fisheye_is_written_for_ros_opencv_and_kalibr(tmp_path):
    camera = camera_model(LENS, SIZE)
    again = read_intrinsics(write_intrinsics(tmp_path / "eye.yaml", camera, "eye"))
    assert (again.model, again.distortion.tolist()) == ("equidistant", LENS[4:].tolist())
    chain = yaml.safe_load(kalibr_text(camera, "eye"))["cam0"]
    assert (chain["camera_model"], chain["distortion_model"]) == ("pinhole", "equidistant")
    assert chain["distortion_coeffs"] == pytest.approx(LENS[4:].tolist())
    (tmp_path / "cv.yaml").write_text(opencv_text(camera, "eye"))
    stored = cv2.FileStorage(str(tmp_path / "cv.yaml"), cv2.FILE_STORAGE_READ)
    assert stored.getNode("fisheye_model").real() == 1.0


def test_a_straight_edge_is_straight_in_the_undistorted_photo():
    camera = camera_model(LENS, SIZE)
    columns, rows = np.meshgrid(np.arange(640.0), np.arange(480.0))
    rays = unproject(LENS, np.column_stack([columns.ravel(), rows.ravel()]))
    photo = np.where(rays[:, 1].reshape(480, 640) > 0.4, 255, 0).astype(np.uint8)
    flat = undistorted(photo, camera, alpha=0.0)
    edge = np.argmax(flat[:, 60:580] > 127, axis=0)
    assert np.ptp(edge) <= 1


def test_a_camera_model_without_distortion_keeps_its_kind():
    assert CameraModel(np.eye(3), np.zeros(4), model="equidistant").distortion.shape == (4,)
