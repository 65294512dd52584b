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
from fsm_calib.world2d.sensor import Light, SensorSettings, expose, noise_field
from fsm_calib.world2d.surfaces import board_points_world, build_scene, marker_corners_world

MOUNT = CameraMount(forward=0.07, left=0.004, height=0.112, pitch=math.radians(21.0), roll=0.01, yaw=0.02)
RATIONAL = CameraModel(
    np.array([[318.0, 0, 316.0], [0, 320.0, 236.0], [0, 0, 1]]),
    # close to an equidistant lens, atan(r) / r, which no plumb_bob follows into the corners
    np.array([0.6842, 0.0747, 3e-4, -4e-4, 0.00067, 1.017, 0.2163, 0.00716]),
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


def test_marker_corners_found_agree_with_projected_truth_in_the_library_order():
    rng = np.random.default_rng(3)
    scene = build_scene(SceneSpec(field=MarkerField(rows=5, columns=5)), rng)
    base = Pose2(0.03, 0.07, math.pi - 0.1)
    camera = nominal_camera()
    image = render(scene, camera, MOUNT, [base], SensorSettings(), rng)
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    corners, numbers, _ = cv2.aruco.ArucoDetector(dictionary, parameters).detectMarkers(image)
    markers = {marker.tag_id: marker for marker in scene.markers}
    errors = []
    for quad, number in zip(corners, numbers.ravel(), strict=True):
        truth = project(marker_corners_world(markers[number]), camera, MOUNT, base)
        if np.min(np.linalg.norm(np.diff(truth[[0, 1, 2, 3, 0]], axis=0), axis=1)) > 60:
            # smaller ones are drawn to the code inside by the refinement's window of 5 px; OpenCV draws a tag
            # turned by half a turn: its corners 1, 0, 3, 2 are the library's 0, 1, 2, 3
            errors.append(quad.reshape(4, 2)[[1, 0, 3, 2]] - truth)
    error = np.concatenate(errors)
    assert len(errors) >= 2
    assert math.sqrt(np.mean(np.sum(error**2, axis=1))) < 0.4
    assert np.all(np.abs(np.median(error, axis=0)) < 0.1)


def test_a_marker_looks_like_sixty_four_rays_a_pixel_traced_one_by_one():
    scene = build_scene(
        SceneSpec(field=MarkerField(rows=3, columns=3, heading_sd=0.05)), np.random.default_rng(3)
    )
    base, camera, fine = Pose2(0.05, 0.05, math.pi - 0.3), nominal_camera(), 8
    marker = scene.markers[4]
    corners = project(marker_corners_world(marker), camera, MOUNT, base)
    (u0, v0), (u1, v1) = np.ceil(corners.min(axis=0)).astype(int), np.floor(corners.max(axis=0)).astype(int)
    sub = (np.arange(fine) + 0.5) / fine - 0.5
    u = (np.arange(u0, u1)[:, None] + sub).ravel()
    v = (np.arange(v0, v1)[:, None] + sub).ravel()
    pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 1, 2)
    rays = cv2.undistortPoints(pixels, camera.matrix, camera.distortion).reshape(-1, 2)
    rotation, position = camera_pose(base, MOUNT)
    directions = np.column_stack([rays, np.ones(len(rays))]) @ rotation.T
    hits = (
        position
        + directions * ((marker_corners_world(marker)[0, 2] - position[2]) / directions[:, 2])[:, None]
    )
    c, s = math.cos(marker.pose.theta), math.sin(marker.pose.theta)
    x, y = hits[:, 0] - marker.pose.x, hits[:, 1] - marker.pose.y
    cell = marker.size / 8
    column, row = (
        np.floor((c * x + s * y) / cell + 4).astype(int),
        np.floor(4 - (c * y - s * x) / cell).astype(int),
    )
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    cells = np.rot90(cv2.aruco.generateImageMarker(dictionary, marker.tag_id, 8), 2) > 127
    inside = (row >= 0) & (row < 8) & (column >= 0) & (column < 8)
    traced = np.where(inside, np.where(cells[row % 8, column % 8], 222.0, 32.0), 222.0)
    traced = traced.reshape(v1 - v0, fine, u1 - u0, fine).mean(axis=(1, 3))
    around = inside.reshape(v1 - v0, fine, u1 - u0, fine).all(axis=(1, 3))
    drawn = Renderer(scene, camera, MOUNT).ideal(base).luma[v0:v1, u0:u1].astype(float)
    difference = (drawn - traced)[around]
    assert around.sum() > 300
    assert abs(difference.mean()) < 1.5
    assert np.sqrt(np.mean(difference**2)) < 12.0


def test_rays_projected_by_opencv_come_back_to_their_pixels():
    for camera in CAMERAS.values():
        rays = ray_table(camera).rays[1:-1:40, 1:-1:40].reshape(-1, 2).astype(float)
        points = np.column_stack([rays, np.ones(len(rays))])
        image, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), camera.matrix, camera.distortion)
        v, u = np.mgrid[0:480:40, 0:640:40]
        assert np.abs(image.reshape(-1, 2) - np.column_stack([u.ravel(), v.ravel()])).max() < 1e-3


def test_a_lens_that_folds_in_the_middle_of_the_image_is_refused():
    camera = CameraModel(nominal_camera().matrix, np.array([-0.6, 0.0, 0.0, 0.0, 0.0]))
    with pytest.raises(InputError, match="folds"):
        ray_table(camera)


def test_a_wall_hides_the_board_behind_it():
    board = BoardPlacement(x=0.8)
    bare = build_scene(SceneSpec(boards=(board,)), np.random.default_rng(0))
    hidden = build_scene(
        SceneSpec(boards=(board,), walls=(Wall(0.5, 0.6, 0.5, -0.6),)), np.random.default_rng(0)
    )
    corners = project(board_points_world(board), nominal_camera(), MOUNT, Pose2()).round().astype(int)
    u0, v0 = corners.min(axis=0)
    u1, v1 = corners.max(axis=0)
    pictures = [
        Renderer(scene, nominal_camera(), MOUNT).ideal(Pose2()).luma[v0:v1, u0:u1] for scene in (bare, hidden)
    ]
    assert np.ptp(pictures[0].astype(int)) > 150
    assert np.ptp(pictures[1].astype(int)) < 60


def test_a_board_in_front_of_a_wall_is_drawn_over_it():
    spec = SceneSpec(boards=(BoardPlacement(x=0.5),), walls=(Wall(0.7, 2.0, 0.9, -2.0),))
    scene = build_scene(spec, np.random.default_rng(0))
    corners = project(board_points_world(spec.boards[0]), nominal_camera(), MOUNT, Pose2())
    image = render(scene, nominal_camera(), MOUNT, [Pose2()], SensorSettings(), np.random.default_rng(0))
    found = find_corners(image, BoardSpec())
    assert min(np.abs(found - corners).max(), np.abs(found[::-1] - corners).max()) < 0.5


def test_turning_during_the_exposure_smears_upright_edges():
    scene = build_scene(SceneSpec(boards=(BoardPlacement(x=0.5),)), np.random.default_rng(0))
    renderer = Renderer(scene, nominal_camera(), MOUNT)
    still = renderer.light([Pose2()])
    moving = renderer.light([Pose2(theta=angle) for angle in np.linspace(-0.01, 0.01, 5)])
    steepest = [np.abs(np.diff(light.luma.astype(int), axis=1)).max() for light in (still, moving)]
    assert steepest[1] < 0.5 * steepest[0]


def test_noise_field_is_standard_normal_and_differs_from_frame_to_frame():
    first, second = (noise_field((480, 640), np.random.default_rng(seed)) for seed in (1, 2))
    assert abs(first.std() - 1.0) < 0.02
    assert abs(first.mean()) < 0.02
    assert abs(np.corrcoef(first.ravel(), second.ravel())[0, 1]) < 0.02


@pytest.mark.parametrize("brightness", [0.2, 0.6])
def test_colours_fade_with_the_light_and_keep_their_hue_and_saturation(brightness):
    yellow = np.full((48, 64, 3), (40, 190, 210), np.uint8)
    luma, *chroma = cv2.split(cv2.cvtColor(yellow, cv2.COLOR_BGR2YCrCb))
    light = Light(luma, np.ascontiguousarray(cv2.merge(chroma)[::2, ::2]))
    camera = CameraModel(np.array([[30.0, 0, 32], [0, 30.0, 24], [0, 0, 1]]), np.zeros(5), 64, 48)
    plain = {"read_noise": 0.0, "shot_noise": 0.0, "vignette": 0.0, "jpeg_quality": 0}
    dim = expose(light, camera, SensorSettings(brightness=brightness, **plain), np.random.default_rng(0))
    assert dim[24, 32] == pytest.approx(yellow[24, 32] * brightness, abs=2.0)


def test_exposure_noise_has_the_variance_of_read_and_shot_noise():
    settings = SensorSettings(defocus=0.0, vignette=0.0, jpeg_quality=0, read_noise=2.0, shot_noise=0.05)
    scene = build_scene(SceneSpec(), np.random.default_rng(0))
    light = Renderer(scene, nominal_camera(), MOUNT).ideal(Pose2())
    a, b = (expose(light, nominal_camera(), settings, np.random.default_rng(s)).astype(float) for s in (1, 2))
    level = light.luma.astype(float)
    expected = math.sqrt(2.0 * np.mean(4.0 + 0.05 * level) + 1.0 / 6.0)  # two frames and their rounding
    assert (a - b)[..., 1].std() == pytest.approx(expected, rel=0.03)
