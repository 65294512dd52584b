"""The lens model: the same pixels as OpenCV, derivatives by finite differences, its inverse, folds."""

import cv2
import numpy as np
import pytest

from fsm_calib.perception.fleet_camera import FLEET_MEDIAN
from fsm_calib.perception.lens import (
    camera_model,
    intrinsics_vector,
    is_sane_over_image,
    project,
    project_with_derivatives,
    unproject,
)
from fsm_calib.perception.prediction import image_grid, projection_difference
from fsm_calib.perception.rotations import rotation_from_vector, vector_from_rotation

PLUMB_BOB = FLEET_MEDIAN
#: near the rational approximation of an equidistant wide lens, atan(r) / r (Pade): one ray for every pixel
RATIONAL = np.array([320.0, 322.0, 318.0, 240.0, 0.778, 0.068, 1e-3, -2e-3, 0.001, 1.111, 0.238, 0.002])
SIZE = (640, 480)


@pytest.fixture
def points() -> np.ndarray:
    rng = np.random.default_rng(1)
    return rng.normal(size=(40, 3)) * [0.3, 0.25, 0.1] + [0.0, 0.0, 0.6]


@pytest.mark.parametrize("vector", [PLUMB_BOB, RATIONAL], ids=["plumb_bob", "rational"])
def test_projection_agrees_with_opencv(vector: np.ndarray, points: np.ndarray) -> None:
    camera = camera_model(vector, SIZE)
    wanted = cv2.projectPoints(points, np.zeros(3), np.zeros(3), camera.matrix, camera.distortion)[0][:, 0]
    np.testing.assert_allclose(project(vector, points), wanted, atol=1e-9)


def test_derivative_by_the_intrinsics_agrees_with_finite_differences(points: np.ndarray) -> None:
    _, _, by_intrinsics = project_with_derivatives(RATIONAL, points)
    steps = 1e-6 * np.eye(12)
    numeric = [(project(RATIONAL + step, points) - project(RATIONAL - step, points)) / 2e-6 for step in steps]
    np.testing.assert_allclose(by_intrinsics, np.stack(numeric, axis=-1), rtol=1e-5, atol=1e-4)


def test_derivative_by_the_point_agrees_with_finite_differences(points: np.ndarray) -> None:
    _, by_point, _ = project_with_derivatives(RATIONAL, points)
    steps = 1e-6 * np.eye(3)
    numeric = [(project(RATIONAL, points + step) - project(RATIONAL, points - step)) / 2e-6 for step in steps]
    np.testing.assert_allclose(by_point, np.stack(numeric, axis=-1), rtol=1e-5, atol=1e-2)


@pytest.mark.parametrize("vector", [PLUMB_BOB, RATIONAL], ids=["plumb_bob", "rational"])
def test_unprojection_undoes_projection_over_the_whole_image(vector: np.ndarray) -> None:
    grid = image_grid(SIZE)
    rays = unproject(vector, grid)
    np.testing.assert_allclose(project(vector, np.column_stack([rays, np.ones(len(rays))])), grid, atol=1e-6)


def test_a_lens_that_folds_before_the_image_corner_is_not_sane() -> None:
    folding = FLEET_MEDIAN.copy()
    folding[4:6] = -0.35, 0.0
    assert is_sane_over_image(FLEET_MEDIAN, SIZE)
    assert not is_sane_over_image(folding, SIZE)


def test_a_pole_inside_the_image_is_not_sane() -> None:
    pole = FLEET_MEDIAN.copy()
    pole[4], pole[9] = -2.6, -2.5
    assert not is_sane_over_image(pole, SIZE)


def test_a_camera_survives_the_way_through_the_vector() -> None:
    camera = camera_model(RATIONAL, SIZE)
    np.testing.assert_array_equal(intrinsics_vector(camera), RATIONAL)
    assert camera.model == "rational_polynomial"


def test_projection_difference_ignores_a_turn_of_the_camera() -> None:
    shifted = FLEET_MEDIAN.copy()
    shifted[2:4] += [1.0, -1.0]
    small = projection_difference(camera_model(FLEET_MEDIAN, SIZE), camera_model(shifted, SIZE)).rms
    longer = FLEET_MEDIAN.copy()
    longer[:2] *= 1.01
    large = projection_difference(camera_model(FLEET_MEDIAN, SIZE), camera_model(longer, SIZE)).rms
    assert small < 1.0 < np.sqrt(2.0) < large


def test_projection_difference_of_a_camera_with_itself_is_nothing() -> None:
    camera = camera_model(FLEET_MEDIAN, SIZE)
    assert projection_difference(camera, camera).max < 1e-6


def test_rotation_vectors_return_also_at_half_a_turn() -> None:
    for vector in ([0.3, -0.2, 0.1], [0.0, 0.0, np.pi - 1e-9], [1e-10, 0.0, 0.0]):
        back = vector_from_rotation(rotation_from_vector(np.array(vector)))
        np.testing.assert_allclose(np.abs(back), np.abs(vector), atol=1e-6)
