"""Poses from tags: from detections, and from images."""

import math

import numpy as np
import pytest

from fsm_calib.errors import InputError
from fsm_calib.perception.rotations import base_from_camera
from fsm_calib.recording.standing_tags import observe_both
from fsm_calib.recording.tag_poses import (
    TagMap,
    TagRow,
    observation,
    pose_from_observations,
    poses_from_tags,
    read_tag_map,
)
from fsm_calib.types import CameraModel, CameraMount, Pose2, TagDetection, TagObservation

MOUNT = CameraMount(forward=0.07, left=0.01, height=0.11, pitch=0.38, yaw=0.03)
TAGS = {300: Pose2(1.0, 0.2, 0.4), 301: Pose2(1.2, -0.1, -2.0)}


def seen_from(robot: Pose2, tag: int, time: float = 0.0) -> TagRow:
    """Return the detection of a tag lying on the floor, by composing rotation matrices."""
    local = robot.inverse().then(TAGS[tag])
    turn, place = base_from_camera(MOUNT)
    c, s = math.cos(local.theta), math.sin(local.theta)
    # x to the tag's right, y down the print, z into the floor
    tag_in_base = np.array([[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, -1.0]])
    rotation = turn.T @ tag_in_base
    translation = turn.T @ (np.array([local.x, local.y, 0.0]) - place)
    w = math.sqrt(max(1.0 + np.trace(rotation), 1e-9)) / 2.0
    off = [rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]]
    return TagRow(time, tag, tuple(translation), (*(value / (4.0 * w) for value in off), w))


@pytest.mark.parametrize("robot", [Pose2(0.5, 0.1, 0.3), Pose2(0.7, -0.4, 1.0)])
@pytest.mark.parametrize("tag", [300, 301])
def test_pose_of_the_robot_follows_from_one_tag(robot, tag):
    track, _ = poses_from_tags([seen_from(robot, tag, 2.0)], TagMap(TAGS, MOUNT))
    assert (track.time[0], track.x[0], track.y[0]) == pytest.approx((2.0, robot.x, robot.y), abs=1e-9)
    assert math.remainder(track.theta[0] - robot.theta, math.tau) == pytest.approx(0.0, abs=1e-6)


def test_tag_that_is_not_on_the_map_is_told():
    rows = [seen_from(Pose2(0.5, 0.0, 0.0), 300), TagRow(0.0, 7, (0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 1.0))]
    _, finding = poses_from_tags(rows, TagMap(TAGS, MOUNT))
    assert (finding.action, finding.rows) == ("dropped", 1)


def test_no_mapped_tag_gives_no_track():
    track, _ = poses_from_tags([TagRow(0.0, 7, (0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 1.0))], TagMap(TAGS, MOUNT))
    assert track is None


def test_nearer_tag_counts_more():
    near = TagObservation(300, 0.2, 0.0, 0.0, 0.2)
    far = TagObservation(301, 2.0, 0.1, 0.0, 2.0)
    tags = {300: Pose2(0.2, 0.0, 0.0), 301: Pose2(2.0, 0.0, 0.0)}
    assert abs(pose_from_observations([near, far], tags).y) < 0.002


def test_heading_is_that_of_the_tags_x_axis():
    seen = observation(seen_from(Pose2(0.5, 0.1, 0.0), 300), MOUNT)
    assert seen.heading == pytest.approx(0.4, abs=1e-9)


def test_map_of_tags_is_read(tmp_path):
    (tmp_path / "tags.yaml").write_text(
        "tags: {300: {x: 1, y: 2, theta: 0.5}}\nmount: {height: 0.12, pitch: 0.4}\n"
    )
    tag_map = read_tag_map(tmp_path / "tags.yaml")
    assert tag_map.tags[300] == Pose2(1.0, 2.0, 0.5)
    assert tag_map.mount.height == 0.12


def test_file_that_is_no_map_of_tags_is_refused(tmp_path):
    (tmp_path / "tags.yaml").write_text("tags: {300: {x: 1}}\n")
    with pytest.raises(InputError, match=r"tags\.yaml:1"):
        read_tag_map(tmp_path / "tags.yaml")


STANDING = {162: Pose2(1.1, 0.3, math.pi / 2.0), 163: Pose2(0.9, -0.35, 2.2)}
LENS = CameraModel(
    np.array([[320.0, 0.0, 320.0], [0.0, 320.0, 240.0], [0.0, 0.0, 1.0]]), np.zeros(5), 640, 480
)


def standing_tag(robot: Pose2, tag: int, size: float = 0.065, middle: float = 0.12) -> TagDetection:
    """Return the corners in the image of an upright tag whose centre is `middle` [m] above the floor."""
    local = robot.inverse().then(STANDING[tag])
    along, up = np.array([math.cos(local.theta), math.sin(local.theta), 0.0]), np.array([0.0, 0.0, 1.0])
    centre = np.array([local.x, local.y, middle])
    corners = [centre + 0.5 * size * (a * along + b * up) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    turn, place = base_from_camera(MOUNT)
    rays = (np.array(corners) - place) @ turn
    pixels = (rays / rays[:, 2:]) @ LENS.matrix.T
    return TagDetection(tag, pixels[:, :2])


@pytest.mark.parametrize("tag", STANDING)
def test_a_standing_tag_tells_the_robots_pose(tag):
    robot = Pose2(0.55, 0.05, 0.1)
    seen = observe_both([standing_tag(robot, tag)], LENS, MOUNT)
    found = pose_from_observations(seen, STANDING)
    assert (found.x, found.y, found.theta) == pytest.approx((robot.x, robot.y, robot.theta), abs=1e-4)


def test_a_standing_tag_that_might_face_two_ways_is_left_out():
    """A tag of nine pixels: a fifth of a pixel of noise lets it face to either side."""
    far = standing_tag(Pose2(-1.2, 0.3, 0.0), 162)
    noise = np.random.default_rng(0).normal(0.0, 0.2, (40, 4, 2))
    seen = [observe_both([TagDetection(162, far.corners_image + n)], LENS, MOUNT) for n in noise]
    assert sum(not tags for tags in seen) > 20


def test_a_standing_tag_may_be_mapped_by_where_it_faces(tmp_path):
    (tmp_path / "tags.yaml").write_text("tags: {162: {x: 1, y: 2, faces: 0.0}}\nsize: 0.08\n")
    tag_map = read_tag_map(tmp_path / "tags.yaml")
    assert tag_map.tags[162] == Pose2(1.0, 2.0, math.pi / 2.0)
    assert tag_map.size == 0.08


@pytest.mark.parametrize(
    "text", ["tags: {1: {x: 1e999, y: 0, theta: 0}}", "tags: {1: {x: 1, y: 0, theta: 0}}\nsize: -1"]
)
def test_a_map_of_tags_with_impossible_numbers_is_refused(tmp_path, text):
    (tmp_path / "tags.yaml").write_text(text)
    with pytest.raises(InputError, match="not a map of tags"):
        read_tag_map(tmp_path / "tags.yaml")
