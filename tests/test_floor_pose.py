"""The robot on a floor of mapped tags: one image, all images together, and where its camera sits by its drives."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from fsm_calib.actions.floor_tracker import camera_offset, moved_to_axle, unwound
from fsm_calib.perception.fleet_camera import fleet_camera
from fsm_calib.perception.floor_map import adjusted_poses, pose_spreads
from fsm_calib.perception.floor_pose import corners_on_map, floor_pose, view_on_floor
from fsm_calib.perception.lens import intrinsics_vector, project
from fsm_calib.perception.rotations import base_from_camera
from fsm_calib.runner.investigation.own_camera import POORLY, well_told
from fsm_calib.types import CameraMount, Pose2, TagDetection

CAMERA, MOUNT = fleet_camera(), CameraMount()
DRAWN = {10 * i + j: Pose2(0.15 * i, 0.15 * j, 0.3) for i in range(6) for j in range(6)}


def seen_from(robot, lying=DRAWN, within=0.6, noise=0.0, rng=None):
    """What an exact camera on a robot at `robot` sees of tags at `lying`."""
    rotation, position = base_from_camera(MOUNT)
    found = []
    for number, pose in lying.items():
        there = robot.inverse().then(pose)
        if not (0.15 < there.x < within and abs(there.y) < 0.5 * there.x):
            continue
        base = np.column_stack([corners_on_map(there, 0.065), np.zeros(4)])
        corners = project(intrinsics_vector(CAMERA), (base - position) @ rotation)
        corners += noise * (rng.standard_normal((4, 2)) if rng else 0.0)
        found.append(TagDetection(number, corners))
    return found


def near(pose, other, place=1e-4, heading=1e-3):
    assert (pose.x, pose.y) == pytest.approx((other.x, other.y), abs=place)
    assert math.remainder(pose.theta - other.theta, math.tau) == pytest.approx(0.0, abs=heading)


@pytest.mark.parametrize("theta", [0.0, 2.0, -2.5])
def test_robot_stands_where_its_tags_say(theta):
    robot = Pose2(0.4, 0.35, theta)
    told = floor_pose(seen_from(robot), CAMERA, MOUNT, DRAWN)
    near(told.pose, robot)
    assert told.tags >= 2


def test_tag_that_was_moved_is_left_out():
    robot = Pose2(0.3, 0.3, 0.4)
    lying = DRAWN | {33: Pose2(0.45, 0.55, 0.3)}
    told = floor_pose(seen_from(robot, lying), CAMERA, MOUNT, DRAWN)
    near(told.pose, robot, 2e-3, 5e-3)
    assert 33 not in {tag[0] for tag in told.seen}


def test_without_a_mapped_tag_there_is_no_pose():
    assert floor_pose(seen_from(Pose2(0.4, 0.35, 0.0)), CAMERA, MOUNT, {}) is None


def test_all_frames_together_know_how_the_tags_were_laid():
    rng = np.random.default_rng(0)
    lying = {
        n: Pose2(p.x + 0.003 * a, p.y + 0.003 * b, p.theta + 0.005 * c)
        for (n, p), (a, b, c) in zip(DRAWN.items(), rng.standard_normal((len(DRAWN), 3)), strict=True)
    }
    robots = [Pose2(0.38 + 0.15 * math.cos(k), 0.38 + 0.15 * math.sin(1.7 * k), 0.21 * k) for k in range(90)]
    told = [floor_pose(seen_from(r, lying, noise=0.2, rng=rng), CAMERA, MOUNT, DRAWN) for r in robots]
    pairs = [(r, t) for r, t in zip(robots, told, strict=True) if t is not None]
    poses, _ = adjusted_poses([t.seen for _, t in pairs], DRAWN)
    off = [math.hypot(p[0] - r.x, p[1] - r.y) for p, (r, _) in zip(poses, pairs, strict=True)]
    plain = [math.hypot(t.pose.x - r.x, t.pose.y - r.y) for r, t in pairs]
    assert np.std(np.array(off)) < 0.6 * np.std(np.array(plain))
    assert np.median(off) < np.median(plain)


def noisy_tags(numbers, sd, rng):
    """Tags of the drawing from the origin, their corners off by `sd` [m] along each axis."""
    square = corners_on_map(Pose2(), 0.065) @ [1.0, 1.0j]
    frame = []
    for number in numbers:
        off = sd * rng.standard_normal((4, 2))
        corners = (corners_on_map(DRAWN[number], 0.065) + off) @ [1.0, 1.0j]
        middle = corners.mean()
        turn = np.angle(np.sum(np.conj(square) * (corners - middle)))
        frame.append((number, middle.real, middle.imag, turn, sd))
    return tuple(frame)


@pytest.mark.parametrize("numbers", [(22,), (11, 12, 22), tuple(DRAWN)])
def test_how_well_tags_tell_a_pose_is_by_what_their_noise_scatters_it(numbers):
    rng, sd = np.random.default_rng(5), 0.004
    frames = [noisy_tags(numbers, sd, rng) for _ in range(400)]
    poses, _ = adjusted_poses(frames, DRAWN)
    place, heading = pose_spreads(frames)[0]
    assert poses[:, 2].std() == pytest.approx(heading, rel=0.12)
    assert math.sqrt(np.linalg.eigvalsh(np.cov(poses[:, :2].T)).max()) == pytest.approx(place, rel=0.12)


def test_poses_that_a_single_tag_tells_are_left_out_where_others_see_many():
    rng = np.random.default_rng(0)
    many, one = (noisy_tags(n, 0.001, rng) for n in ((11, 12, 21, 22, 31, 33), (22,)))
    drives = [SimpleNamespace(seen=[many, one] + [many] * 20), SimpleNamespace(seen=[many] * 3)]
    long, short = well_told(drives, 0.065)
    assert long.tolist() == [True, False] + [True] * 20
    assert short.all()
    assert pose_spreads([one])[0, 1] > POORLY * pose_spreads([many])[0, 1]


def test_a_drive_that_would_be_too_short_without_them_keeps_its_poor_poses():
    rng = np.random.default_rng(0)
    many, one = (noisy_tags(n, 0.001, rng) for n in ((11, 12, 21, 22, 31, 33), (22,)))
    drives = [SimpleNamespace(seen=[many] * 40), SimpleNamespace(seen=[many] * 15 + [one] * 8)]
    assert well_told(drives, 0.065)[1].all()


def test_poses_are_kept_where_all_are_told_alike():
    lonely = noisy_tags((22,), 0.001, np.random.default_rng(0))
    assert well_told([SimpleNamespace(seen=[lonely] * 4)], 0.065)[0].all()


def driven(ahead=0.0, yaw=0.0):
    """Poses of a robot that turns and drives ideally, told by a camera `ahead` [m] of where it is taken to be."""
    rows, x, y, theta = [], 0.0, 0.0, 0.0
    for k in range(120):
        v, omega = (0.2, 0.3) if k // 20 % 2 else (0.0, 1.5)
        middle, theta = theta + 0.05 * omega, theta + 0.1 * omega
        x, y = x + 0.1 * v * math.cos(middle), y + 0.1 * v * math.sin(middle)
        rows.append((0.1 * k, x + ahead * math.cos(theta), y + ahead * math.sin(theta), theta - yaw))
    return rows


def test_drives_tell_how_the_camera_sits():
    ahead, yaw = camera_offset([driven(0.004, 0.012)])
    assert (ahead, yaw) == pytest.approx((0.004, 0.012), abs=4e-4)
    back = moved_to_axle(driven(0.004, 0.012), 0.004, 0.012)
    assert np.allclose(back, driven(), atol=1e-9)


def test_few_poses_tell_nothing_of_the_camera():
    assert camera_offset([driven(0.004)[:10]]) == (0.0, 0.0)


def test_headings_go_on_as_commanded_over_a_gap_of_more_than_half_a_turn():
    commands = [(0.0, -0.3, 0.3)]
    rows = [(t, 0.0, 0.0, math.remainder(3.6 * t, math.tau)) for t in (0.0, 0.2, 1.5, 1.6)]
    assert [row[3] for row in unwound(rows, commands, 12.0)] == pytest.approx([0.0, 0.72, 5.4, 5.76])


def test_tags_are_in_view_ahead_and_not_behind():
    cells = np.array([[0.3, 0.0], [-0.3, 0.0], [0.3, 2.0], [0.9, 0.0]])
    assert view_on_floor(CAMERA, MOUNT, cells).tolist() == [True, False, False, False]
