"""From pixels to observations, on rendered images whose truth is known: boards, tags, lane, sharpness."""

import math
from dataclasses import replace
from functools import lru_cache

import cv2
import numpy as np
import pytest

from fsm_calib.actions.settings_moving import DriveSettings
from fsm_calib.errors import DataError
from fsm_calib.perception import chessboard
from fsm_calib.perception.board_order import canonical_order, half_turned
from fsm_calib.perception.chessboard import find_board, find_boards, inspect_board
from fsm_calib.perception.corner_bias import curvature_bias, pull_of_edges
from fsm_calib.perception.corner_grid import straightened
from fsm_calib.perception.focus import read_focus
from fsm_calib.perception.ground import floor_points, observe_tags
from fsm_calib.perception.lane import observe_lane
from fsm_calib.perception.lens import intrinsics_vector, project
from fsm_calib.perception.rotations import base_from_camera, mount_from_pose, yaw_rotation
from fsm_calib.perception.sharpness import block_dct, sharpness
from fsm_calib.perception.tags import find_tags
from fsm_calib.perception.tape_colours import tape_masks, tape_values
from fsm_calib.perception.tilt import estimate_tilt
from fsm_calib.perception.turning import likeness_above, panorama
from fsm_calib.types import BoardSpec, CameraMount, Pose2
from fsm_calib.world2d.camera import Renderer
from fsm_calib.world2d.fleet import nominal_camera
from fsm_calib.world2d.layout import calibration_area
from fsm_calib.world2d.scene import BoardPlacement, SceneSpec
from fsm_calib.world2d.sensor import SensorSettings, expose
from fsm_calib.world2d.surfaces import Scene, board_points_world, build_scene, marker_corners_world

CAMERA, BOARD = nominal_camera(), BoardSpec()
MOUNT = CameraMount(height=0.113, roll=math.radians(0.5))
CORNER_BAR_PX = 0.1  # rms of corners over a view


@lru_cache(maxsize=1)
def area() -> Scene:
    return build_scene(calibration_area(), np.random.default_rng(1))


ORIGIN = Pose2()


def photo(scene: Scene, pose: Pose2 = ORIGIN, seed: int = 0, **sensor: float) -> np.ndarray:
    light = Renderer(scene, CAMERA, MOUNT).ideal(pose)
    return expose(light, CAMERA, SensorSettings(**sensor), np.random.default_rng(seed))  # type: ignore[arg-type]


def board_scene(*placements: BoardPlacement) -> Scene:
    return build_scene(SceneSpec(boards=placements), np.random.default_rng(1))


def true_corners(placement: BoardPlacement) -> np.ndarray:
    rotation, position = base_from_camera(MOUNT)
    return project(intrinsics_vector(CAMERA), (board_points_world(placement) - position) @ rotation)


def distance_of(found: np.ndarray, true: np.ndarray) -> float:
    errors = [np.sqrt(np.mean(np.sum((found - way) ** 2, axis=1))) for way in (true, half_turned(true))]
    return float(min(errors))


PLACEMENTS = {
    "near": BoardPlacement(BOARD, x=0.35),
    "far: 10 px squares": BoardPlacement(BOARD, x=0.95, lean=0.2),
    "leaned and turned": BoardPlacement(BOARD, x=0.5, y=0.1, yaw=math.pi + 0.5, lean=0.6),
    "flat on the floor": BoardPlacement(BOARD, x=0.37, lean=math.pi / 2.0),
}


@pytest.mark.parametrize("name", PLACEMENTS)
def test_corners_are_within_a_tenth_of_a_pixel(name: str) -> None:
    placement = PLACEMENTS[name]
    view = find_board(photo(board_scene(placement)), BOARD)
    assert view is not None
    assert distance_of(view.corners_image, true_corners(placement)) < CORNER_BAR_PX


def test_corners_that_stand_out_are_put_where_the_others_expect_them() -> None:
    true = true_corners(PLACEMENTS["flat on the floor"])
    shifted = true.copy()
    shifted[[3, 16]] += [(0.4 * 21.0, 0.0), (0.0, -9.0)]
    found = straightened(shifted, BOARD, 0.2)
    assert found is not None
    assert np.linalg.norm(found - true, axis=1).max() < 1.5
    assert np.array_equal(np.delete(found, [3, 16], axis=0), np.delete(true, [3, 16], axis=0))
    assert straightened(true, BOARD, 0.2) is None


@pytest.mark.parametrize(("corner", "shift"), [(3, (0.0, 3.0)), (10, (-3.0, -3.0)), (17, (0.0, 3.0))])
def test_a_corner_that_runs_away_from_a_misplaced_start_does_not_lose_the_board(
    monkeypatch, corner, shift
) -> None:
    placement = PLACEMENTS["flat on the floor"]
    image, rough = photo(board_scene(placement)), chessboard._rough_corners

    def careless(*arguments):
        corners = rough(*arguments)
        corners[corner] += shift
        return corners

    monkeypatch.setattr(chessboard, "_rough_corners", careless)
    view = find_board(image, BOARD)
    assert view is not None
    assert distance_of(view.corners_image, true_corners(placement)) < CORNER_BAR_PX


def test_the_tutorials_window_would_ruin_small_squares() -> None:
    placement = PLACEMENTS["far: 10 px squares"]
    gray = cv2.cvtColor(photo(board_scene(placement)), cv2.COLOR_BGR2GRAY)
    true = true_corners(placement)
    start = true.astype(np.float32).reshape(-1, 1, 2)
    wide = cv2.cornerSubPix(gray, start, (11, 11), (-1, -1), (3, 30, 0.005)).reshape(-1, 2)
    assert distance_of(wide, true) > 10.0 * CORNER_BAR_PX


def test_two_boards_in_a_frame_are_told_apart_from_left_to_right() -> None:
    left = BoardPlacement(BOARD, x=0.55, y=0.2, yaw=math.pi + 0.3)
    right = BoardPlacement(BOARD, x=0.55, y=-0.2, yaw=math.pi - 0.3)
    views = find_boards(photo(board_scene(right, left)), BOARD)
    assert [view.board for view in views] == [0, 1]
    for view, placement in zip(views, (left, right), strict=True):
        assert distance_of(view.corners_image, true_corners(placement)) < CORNER_BAR_PX


def test_a_blurred_board_is_refused_with_its_edge_width() -> None:
    finding = inspect_board(photo(board_scene(PLACEMENTS["near"]), defocus=4.0), BOARD)
    assert finding.view is None
    assert "blurred" in finding.refusal
    assert finding.edge_width_px > 6.0


def test_a_board_that_is_cut_by_the_border_is_refused() -> None:
    cut = BoardPlacement(BOARD, x=0.4, y=0.38)
    assert inspect_board(photo(board_scene(cut)), BOARD).view is None


@pytest.mark.parametrize(
    ("image", "reason"),
    [(np.full((480, 640), 90, np.uint8), "uniform"), (np.full((480, 640, 3), 90, np.uint8), "uniform")],
)
def test_an_image_without_contrast_is_named_so(image: np.ndarray, reason: str) -> None:
    assert reason in inspect_board(image, BOARD).refusal


@pytest.mark.parametrize("board", [BoardSpec(7, 5), BoardSpec(9, 6), BoardSpec(8, 6)], ids=str)
def test_corner_order_is_the_same_whatever_the_detector_returned(board: BoardSpec) -> None:
    squares = np.add.outer(np.arange(board.rows + 1), np.arange(board.columns + 1)) % 2
    gray = np.kron(255 * (1 - squares), np.ones((20, 20))).astype(np.uint8)
    grid = np.mgrid[0 : board.columns, 0 : board.rows].T.reshape(-1, 2) * 20.0 + 19.5
    table = grid.reshape(board.rows, board.columns, 2)
    mirrored = table[:, ::-1].reshape(-1, 2)
    wanted = canonical_order(grid, gray, board)
    for given in (half_turned(grid), mirrored, half_turned(mirrored)):
        np.testing.assert_array_equal(canonical_order(given, gray, board), wanted)


def test_colours_fix_the_order_of_a_board_that_is_not_ambiguous() -> None:
    board = BoardSpec(9, 6)
    squares = np.add.outer(np.arange(7), np.arange(10)) % 2
    gray = np.kron(255 * (1 - squares), np.ones((20, 20))).astype(np.uint8)
    grid = np.mgrid[0:9, 0:6].T.reshape(-1, 2) * 20.0 + 19.5
    upside_down = np.ascontiguousarray(gray[::-1, ::-1])
    turned = canonical_order(np.array([199.0, 139.0]) - grid, upside_down, board)
    np.testing.assert_allclose(turned, np.array([199.0, 139.0]) - canonical_order(grid, gray, board))


def bent_corner(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a corner's place (2,) [px] in a picture of 41 px, its edges' normals (2, 2) and curvatures (2,) [1/px]."""
    first = rng.uniform(0.0, math.pi)
    angles = np.array([first, first + rng.uniform(1.0, 2.1)])
    normals = np.column_stack([-np.sin(angles), np.cos(angles)])
    return rng.uniform(19.5, 20.5, 2), normals, rng.normal(0.0, 0.02, 2)


def picture_of_corner(
    place: np.ndarray, normals: np.ndarray, curvatures: np.ndarray, gain: float
) -> np.ndarray:
    """Return the picture of two bent edges that cross, blurred and lit by `gain`."""
    fine = (np.arange(41 * 6) + 0.5) / 6 - 0.5
    x, y = np.meshgrid(fine - place[0], fine - place[1])
    sides = [
        n[0] * x + n[1] * y - k * (n[1] * x - n[0] * y) ** 2 / 2
        for n, k in zip(normals, curvatures, strict=True)
    ]
    light = np.where(sides[0] * sides[1] > 0.0, 200.0, 20.0).reshape(41, 6, 41, 6).mean(axis=(1, 3))
    return np.clip(np.rint(gain * cv2.GaussianBlur(light, (0, 0), 0.7)), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("half", [4, 9])
@pytest.mark.parametrize("gain", [1.0, 1.8])
def test_search_between_bent_edges_is_off_by_the_computed_bias_in_any_light(half: int, gain: float) -> None:
    rng = np.random.default_rng(4)
    found, computed = [], []
    for _ in range(150):
        place, normals, curvatures = bent_corner(rng)
        ends = []
        for way in (-curvatures, curvatures):  # where pixels lie is the same in both and cancels
            gray = picture_of_corner(place, normals, way, gain)
            end = chessboard._searched(gray, place[None], np.array([half]))
            ends.append((end[0], pull_of_edges(gray, end, half, normals[None], way[None])[0]))
        found.append(ends[1][0] - ends[0][0])
        computed.append(ends[1][1] - ends[0][1])
    share = np.sum(np.multiply(found, computed)) / np.sum(np.square(computed))
    assert share == pytest.approx(1.0, abs=0.1)


def test_straight_edges_have_no_bias() -> None:
    board = BoardSpec(7, 5)
    grid = np.mgrid[0:7, 0:5].T.reshape(-1, 2) * 30.0 + 20.0
    gray = np.random.default_rng(0).integers(0, 255, (200, 240), dtype=np.uint8)
    np.testing.assert_allclose(curvature_bias(gray, grid, np.full(35, 6), board), 0.0, atol=1e-12)


def test_bent_rows_pull_their_corners_towards_the_inside_of_the_bend() -> None:
    board = BoardSpec(7, 5)
    grid = np.mgrid[0:7, 0:5].T.reshape(-1, 2) * 30.0 + 20.0
    bent = grid + np.column_stack([np.zeros(35), 0.5e-3 * (grid[:, 0] - 110.0) ** 2])
    gray = np.random.default_rng(0).integers(0, 255, (220, 240), dtype=np.uint8)
    bias = curvature_bias(gray, bent, np.full(35, 6), board)
    assert np.all(bias[:, 1] < 0.0)


def test_tags_have_the_library_order_and_pixel_centres_at_whole_numbers() -> None:
    pose = Pose2(area().spec.field.first_x + 0.18, 0.01, math.pi - 0.1)
    rotation, position = base_from_camera(MOUNT)
    seen = observe_tags(found := find_tags(photo(area(), pose)), CAMERA, MOUNT)
    corners = {tag.tag_id: tag.corners_image for tag in found}
    prints = {marker.tag_id: marker for marker in area().markers}
    offsets = []
    for tag in seen[:2]:
        world = marker_corners_world(prints[tag.tag_id]) - [pose.x, pose.y, 0.0]
        base = world @ yaw_rotation(pose.theta)
        true = project(intrinsics_vector(CAMERA), (base - position) @ rotation)
        offsets.append(corners[tag.tag_id] - true)
    assert np.abs(np.median(np.concatenate(offsets), axis=0)).max() < 0.15
    assert np.abs(np.concatenate(offsets)).max() < 1.0


@pytest.mark.parametrize("turn", [-0.3, 0.0, 0.2])
def test_the_nearest_tags_heading_is_that_of_the_floor(turn: float) -> None:
    pose = Pose2(area().spec.field.first_x + 0.22, 0.01, math.pi + turn)
    seen = observe_tags(find_tags(photo(area(), pose)), CAMERA, MOUNT)
    marker = next(marker for marker in area().markers if marker.tag_id == seen[0].tag_id)
    true = pose.inverse().then(marker.pose)
    assert seen[0].heading == pytest.approx(true.theta, abs=math.radians(0.5))
    assert math.hypot(seen[0].x - true.x, seen[0].y - true.y) < 0.004
    assert [tag.distance for tag in seen] == sorted(tag.distance for tag in seen)


def test_the_papers_reading_shrinks_the_heading_by_the_sine_of_the_pitch() -> None:
    readings = []
    for turn in (-0.2, 0.2):
        pose = Pose2(area().spec.field.first_x + 0.22, 0.01, math.pi + turn)
        readings.append(observe_tags(find_tags(photo(area(), pose)), CAMERA, MOUNT)[0])
    first, second = readings
    assert first.tag_id == second.tag_id
    slope = (second.heading_camera - first.heading_camera) / (second.heading - first.heading)
    assert slope == pytest.approx(math.sin(MOUNT.pitch), rel=0.05)


def test_tags_tell_pitch_roll_and_height() -> None:
    pose = Pose2(area().spec.field.first_x + 0.22, 0.0, math.pi)
    tilt = estimate_tilt(find_tags(photo(area(), pose)), CAMERA)
    assert tilt.pitch == pytest.approx(MOUNT.pitch, abs=math.radians(0.3))
    assert tilt.roll == pytest.approx(MOUNT.roll, abs=math.radians(0.3))
    assert tilt.height == pytest.approx(MOUNT.height, abs=0.002)


@pytest.mark.parametrize("thorough", [False, True])
@pytest.mark.parametrize("shape", [(32888, 160), (14, 14), (480, 1)])
def test_a_strip_too_narrow_for_any_board_has_none(shape: tuple[int, int], thorough: bool) -> None:
    strip = np.random.default_rng(0).integers(0, 255, shape).astype(np.uint8)
    finding = inspect_board(strip, BOARD, thorough=thorough)
    assert finding.view is None
    assert finding.refusal


def test_no_tag_is_an_error_with_a_cure() -> None:
    with pytest.raises(DataError, match="no floor tag"):
        estimate_tilt((), CAMERA)


def test_a_tag_that_does_not_lie_on_the_floor_is_left_out() -> None:
    pose = Pose2(area().spec.field.first_x + 0.22, 0.01, math.pi)
    detections = find_tags(photo(area(), pose))
    tipped = replace(MOUNT, pitch=MOUNT.pitch + math.radians(20.0))
    assert observe_tags(detections, CAMERA, tipped) == ()


@pytest.mark.parametrize(
    ("moved", "blur", "is_same"),
    [(Pose2(0.05, 0.03, 0.06), 0.6, True), (Pose2(0.05, 0.03, 0.06), 5.0, True), (Pose2(-0.6), 0.6, False)],
)
def test_what_stands_far_off_tells_whether_the_robot_is_back(
    moved: Pose2, blur: float, is_same: bool
) -> None:
    start = Pose2(area().spec.field.first_x + 0.22, 0.0, math.pi)
    without_markers = build_scene(replace(calibration_area(), field=None), np.random.default_rng(1))
    before, after = photo(area(), start), photo(without_markers, start.then(moved), 1, defocus=blur)
    likeness = likeness_above(panorama(before), panorama(after))
    assert (likeness >= DriveSettings().same_place) is is_same


@pytest.mark.parametrize(("d", "phi"), [(0.0, 0.0), (0.05, -0.2), (-0.04, 0.25)])
def test_the_lane_pose_is_left_and_counter_clockwise_positive(d: float, phi: float) -> None:
    pose = area().spec.road.start.then(Pose2(0.9, d, phi))
    lane = observe_lane(photo(area(), pose), CAMERA, MOUNT)
    assert lane is not None
    assert lane.d == pytest.approx(d, abs=0.01)
    assert lane.phi == pytest.approx(phi, abs=0.03)


@pytest.mark.parametrize("brightness", [0.1, 0.3, 2.0, 3.0])
def test_the_lane_is_seen_in_rooms_of_any_light(brightness: float) -> None:
    pose = area().spec.road.start.then(Pose2(0.9, 0.03, 0.2))
    lane = observe_lane(photo(area(), pose, brightness=brightness), CAMERA, MOUNT)
    assert lane is not None
    assert (lane.d, lane.phi) == (pytest.approx(0.03, abs=0.01), pytest.approx(0.2, abs=0.03))


@pytest.mark.parametrize("brightness", [0.1, 1.0, 3.0])
def test_no_lane_is_seen_on_a_bare_floor(brightness: float) -> None:
    bare = build_scene(SceneSpec(), np.random.default_rng(1))
    assert observe_lane(photo(bare, brightness=brightness), CAMERA, MOUNT) is None


def test_a_lane_across_the_way_is_not_taken_for_one_along_it() -> None:
    pose = area().spec.road.start.then(Pose2(0.9, 0.0, math.radians(80.0)))
    lane = observe_lane(photo(area(), pose, brightness=0.7), CAMERA, MOUNT)
    assert lane is None or abs(lane.phi) > math.radians(35.0)


def hsv_floor(white: int, yellow: int, *, light: float = 1.0) -> np.ndarray:
    """Return 200 pixels of grey floor, and of white and yellow tape, in hue, saturation and value."""
    grey, paper, tape = (0, 10, 80.0 * light), (0, 10, 210.0 * light), (30, 180, 200.0 * light)
    return np.array([grey] * 200 + [paper] * white + [tape] * yellow, dtype=np.uint8)


@pytest.mark.parametrize("light", [0.1, 0.5, 1.2])
def test_white_begins_between_the_floor_and_the_tape(light: float) -> None:
    begins = tape_values(hsv_floor(20, 10, light=light))
    assert 80.0 * light <= begins.white <= 210.0 * light
    assert 80.0 * light <= begins.yellow <= 200.0 * light


def test_a_floor_without_tape_has_no_white_and_yellow_only_above_its_own_value() -> None:
    assert tape_values(hsv_floor(0, 0)) == (256.0, 80.0)


def test_no_floor_in_sight_has_no_tape() -> None:
    masks = tape_masks(np.zeros((4, 4, 3), np.uint8), tape_values(np.empty((0, 3), np.uint8)))
    assert not any(mask.any() for mask in masks)


def test_a_floor_point_projects_back_to_its_pixel() -> None:
    pixels = np.array([[320.0, 300.0], [100.0, 400.0]])
    base = np.column_stack([floor_points(pixels, CAMERA, MOUNT), np.zeros(2)])
    rotation, position = base_from_camera(MOUNT)
    np.testing.assert_allclose(
        project(intrinsics_vector(CAMERA), (base - position) @ rotation), pixels, atol=1e-6
    )


def test_a_pixel_above_the_horizon_has_no_floor_point() -> None:
    assert np.isnan(floor_points(np.array([[320.0, 5.0]]), CAMERA, MOUNT)).all()


def test_a_mount_survives_the_way_through_its_pose() -> None:
    mount = CameraMount(0.07, 0.01, 0.11, 0.4, -0.05, 0.1)
    back = mount_from_pose(*base_from_camera(mount))
    for name in ("forward", "left", "height", "pitch", "roll", "yaw"):
        assert getattr(back, name) == pytest.approx(getattr(mount, name), abs=1e-12)


def test_block_dct_agrees_with_opencv() -> None:
    gray = np.random.default_rng(0).integers(0, 255, (16, 24)).astype(np.uint8)
    np.testing.assert_allclose(
        block_dct(gray)[1, 2], cv2.dct(gray[8:16, 16:24].astype(np.float32)), atol=1e-2
    )


@pytest.mark.parametrize("read_noise", [1.0, 10.0])
def test_sharpness_falls_as_the_board_blurs_and_keeps_its_scale_under_noise(read_noise: float) -> None:
    scene = board_scene(PLACEMENTS["near"])
    blurs = (0.5, 1.0, 2.0, 4.0)
    values = [sharpness(photo(scene, defocus=blur, read_noise=read_noise, jpeg_quality=0)) for blur in blurs]
    assert values == sorted(values, reverse=True)
    assert 0.3 < values[1] / values[0] < 0.9


def test_sharpness_of_a_uniform_image_is_nothing() -> None:
    assert sharpness(np.full((64, 64), 100, np.uint8)) == 0.0


def test_focus_tells_when_the_sharp_point_has_been_passed() -> None:
    assert not read_focus([0.1, 0.2, 0.3]).has_passed
    passed = read_focus([0.1, 0.3, 0.2])
    assert passed.has_passed
    assert passed.best_index == 1
    assert "turn back" in passed.sentence
