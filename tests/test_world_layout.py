"""The default areas: what a robot at the start can see, reach and hit."""

import math
from itertools import pairwise

import cv2
import numpy as np
import pytest

from fsm_calib.errors import InputError
from fsm_calib.types import CameraMount, Pose2
from fsm_calib.world2d.fleet import nominal_camera
from fsm_calib.world2d.layout import calibration_area, lane_beyond, mixed_boards, upright_boards
from fsm_calib.world2d.lens import camera_pose
from fsm_calib.world2d.obstacles import ROBOT_FRONT, ROBOT_WIDTH
from fsm_calib.world2d.scene import MarkerField, Road
from fsm_calib.world2d.surfaces import board_points_world, board_surface, build_scene

LAYOUTS = {
    f"{kind.__name__} {count}": kind(count)
    for kind in (mixed_boards, upright_boards)
    for count in (1, 2, 3, 4)
}
MOUNTS = [CameraMount(height=0.11, pitch=math.radians(angle)) for angle in (16.0, 22.0, 27.0)]


def corners_image(placement, mount, heading):
    rotation, position = camera_pose(Pose2(theta=heading), mount)
    points = board_points_world(placement)
    if ((points - position) @ rotation)[:, 2].min() < 0.05:
        return np.full((1, 2), -1.0)
    rvec, _ = cv2.Rodrigues(rotation.T)
    camera = nominal_camera()
    return cv2.projectPoints(points, rvec, -rotation.T @ position, camera.matrix, camera.distortion)[
        0
    ].reshape(-1, 2)


@pytest.mark.parametrize("name", LAYOUTS)
@pytest.mark.parametrize("mount", MOUNTS, ids=["16 deg", "22 deg", "27 deg"])
def test_every_board_lies_fully_in_view_from_at_least_ten_headings(name, mount):
    headings = np.radians(np.arange(-180, 180, 4))
    for placement in LAYOUTS[name]:
        views = [corners_image(placement, mount, heading) for heading in headings]
        fully = [v.min() > 8 and v[:, 0].max() < 631 and v[:, 1].max() < 471 for v in views]
        assert sum(fully) >= 10


@pytest.mark.parametrize("name", LAYOUTS)
def test_a_robot_turning_on_either_wheel_touches_no_board(name):
    reach = (
        math.hypot(ROBOT_FRONT, ROBOT_WIDTH) + 0.05
    )  # m, corner about the far wheel, and half an axle from the start
    for placement in LAYOUTS[name]:
        if placement.kind != "flat":
            corners = board_surface(placement, 0).corners_world()[:, :2]
            steps = np.linspace(0.0, 1.0, 20)[:, None]
            edges = [corners[i] + steps * (corners[(i + 1) % 4] - corners[i]) for i in range(4)]
            assert np.linalg.norm(np.concatenate(edges), axis=1).min() > reach


@pytest.mark.parametrize("name", LAYOUTS)
def test_boards_do_not_cover_each_other_as_seen_from_the_start(name):
    spans = []
    for placement in LAYOUTS[name]:
        corners = board_surface(placement, 0).corners_world()
        angles = np.unwrap(np.arctan2(corners[:, 1], corners[:, 0]))
        spans.append((angles.min(), angles.max()))
    assert all(before[1] < after[0] for before, after in pairwise(spans))


def test_a_robot_driving_along_the_field_sees_markers_at_heading_zero():
    scene = build_scene(calibration_area(), np.random.default_rng(0))
    robot = Pose2(0.0, 0.0, math.pi)
    headings = [robot.inverse().then(marker.pose).theta for marker in scene.markers if marker.tag_id >= 300]
    assert np.abs(headings).max() < 0.03


def test_the_field_is_long_enough_for_the_longest_run_and_three_markers_ahead():
    field = MarkerField()
    longest_run, ahead = 0.70, 0.07 + 3 * field.pitch
    assert -field.last_x >= longest_run + ahead


def test_the_lanes_first_marker_has_the_reserved_number_and_a_tile_before_and_behind():
    scene = build_scene(calibration_area(), np.random.default_rng(0))
    road = scene.spec.road
    in_lane = [road.start.inverse().then(m.pose) for m in scene.markers if m.tag_id < 300]
    assert next(m.tag_id for m in scene.markers if m.tag_id < 300) == road.first_id
    assert all(abs(pose.y) < 0.03 and abs(pose.theta) < 0.03 for pose in in_lane)
    assert in_lane[0].x > 0.585
    assert road.length - in_lane[-1].x > 0.585


def test_no_marker_number_appears_twice():
    numbers = [marker.tag_id for marker in build_scene(calibration_area(), np.random.default_rng(0)).markers]
    assert len(numbers) == len(set(numbers))


def test_the_white_line_clears_the_last_markers():
    field = MarkerField()
    road = lane_beyond(field)
    right_edge = road.start.x + 0.5 * road.lane_width + road.white_width
    assert right_edge < field.last_x - 0.5 * field.size


@pytest.mark.parametrize("count", [0, 7])
def test_counts_of_boards_that_do_not_fit_are_refused(count):
    with pytest.raises(InputError):
        mixed_boards(count)


def test_lane_markers_beyond_the_road_are_refused():
    with pytest.raises(InputError, match="reach beyond"):
        Road(markers=30)
