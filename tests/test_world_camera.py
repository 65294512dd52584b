"""The rendered camera against OpenCV's own projection, a route that shares no code with the renderer."""

import math

import cv2
import numpy as np
import pytest

from fsm_calib.errors import InputError
from fsm_calib.types import BoardSpec, CameraModel, CameraMount, Pose2
from fsm_calib.world2d.camera import Renderer, render
from fsm_calib.world2d.fleet import nominal_camera
from fsm_calib.world2d.lens import camera_pose, ray_table
from fsm_calib.world2d.scene import BoardPlacement, MarkerField, SceneSpec, Wall
from fsm_calib.world2d.sensor import SensorSettings, expose, noise_field
from fsm_calib.world2d.surfaces import board_points_world, build_scene, marker_corners_world

MOUNT = CameraMount(forward=0.07, left=0.004, height=0.112, pitch=math.radians(21.0), roll=0.01, yaw=0.02)
RATIONAL = CameraModel(
    np.array([[318.0, 0, 316.0], [0, 320.0, 236.0], [0, 0, 1]]),
    # an equidistant lens (theta = r) to a few hundredths of a pixel, by its own series in r^2
    np.array([1.1, 0.16, 3e-4, -4e-4, 0.002, 1.4333, 0.4376, 0.0232]),
    model="rational_polynomial",
)
CAMERAS = {"plumb_bob": nominal_camera(), "rational": RATIONAL}
CLEAN = SensorSettings(defocus=0.0, read_noise=0.0, shot_noise=0.0, vignette=0.0, jpeg_quality=0)
BOARDS = {
    "upright near": BoardPlacement(x=0.50, y=0.04, yaw=math.pi),
    "upright far": BoardPlacement(x=1.05, y=-0.1, yaw=math.pi),
    "turned": BoardPlacement(x=0.55, y=0.2, yaw=math.pi - 0.5),
    "leaned": BoardPlacement(x=0.48, y=-0.12, yaw=math.pi + 0.3, lean=0.55),
    "flat": BoardPlacement(x=0.38, y=0.03, yaw=math.pi + 0.2, lean=math.pi / 2),
    "flat near": BoardPlacement(x=0.29, y=0.0, yaw=math.pi, lean=math.pi / 2),
}


def project(points, camera, mount, base):
    rotation, position = camera_pose(base, mount)
    rvec, _ = cv2.Rodrigues(rotation.T)
    image, _ = cv2.projectPoints(points, rvec, -rotation.T @ position, camera.matrix, camera.distortion)
    return image.reshape(-1, 2)


def find_corners(image, board):
    gray = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    found, corners = cv2.findChessboardCorners(gray, (board.columns, board.rows))
    assert found
    grid = corners.reshape(board.rows, board.columns, 2)
    spacing = min(np.linalg.norm(np.diff(grid, axis=axis), axis=2).min() for axis in (0, 1))
    half = int(np.clip(0.4 * spacing, 3, 11))
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 50, 1e-4)
    return cv2.cornerSubPix(gray, corners, (half, half), (-1, -1), criteria).reshape(-1, 2)


def corner_errors(placement, camera, settings, seed=1):
    rng = np.random.default_rng(seed)
    scene = build_scene(SceneSpec(boards=(placement,)), rng)
    image = render(scene, camera, MOUNT, [Pose2()], settings, rng)
    truth = project(board_points_world(placement), camera, MOUNT, Pose2())
    found = find_corners(image, placement.board)
    error = min((found - truth, found[::-1] - truth), key=lambda e: np.abs(e).sum())
    return error


@pytest.mark.parametrize("lens", CAMERAS)
@pytest.mark.parametrize("name", BOARDS)
def test_corners_found_agree_with_projected_truth(name, lens):
    error = corner_errors(BOARDS[name], CAMERAS[lens], SensorSettings())
    assert math.sqrt(np.mean(np.sum(error**2, axis=1))) < 0.1


@pytest.mark.parametrize("name", BOARDS)
def test_corners_have_no_common_offset_without_noise(name):
    error = corner_errors(BOARDS[name], CAMERAS["plumb_bob"], CLEAN)
    assert np.all(np.abs(error.mean(axis=0)) < 0.03)
