"""Calibration by hand: what a careful person gets from real pixels and from a tape line."""

from dataclasses import replace

import numpy as np
import pytest

from fsm_calib.perception.chessboard import inspect_board
from fsm_calib.perception.lens import intrinsics_vector, project
from fsm_calib.perception.prediction import projection_difference
from fsm_calib.study.hand_camera import calibrate_by_hand, mount_by_hand
from fsm_calib.study.hand_wheels import (
    TapeDrive,
    adjusted_trim,
    calibrate_wheels_by_hand,
    ratio_of,
)
from fsm_calib.study.held_board import (
    CameraPose,
    HandMotion,
    HandWork,
    HeldBoard,
    held_pose,
    moved,
    row_shares,
)
from fsm_calib.study.operator import OperatorSettings
from fsm_calib.types import BoardSpec
from fsm_calib.world2d.deviation import straight_deviation
from fsm_calib.world2d.fleet import nominal_robot
from fsm_calib.world2d.robot import WorldSettings
from fsm_calib.world2d.sensor import SensorSettings

BOARD = BoardSpec()
STILL = OperatorSettings(tremor_speed=0.0, tremor_rate=0.0, fast_share=0.0, views=12)


def test_the_shares_of_the_drawings_add_up_to_one_in_every_row():
    shares = row_shares(np.linspace(-0.014, 0.014, 9), 480, readout=0.02, exposure=0.008)
    assert shares.sum(axis=0) == pytest.approx(np.ones(480), abs=1e-5)


def test_a_rows_mean_moment_runs_with_the_readout():
    moments = np.linspace(-0.014, 0.014, 9)
    mean = moments @ row_shares(moments, 480, readout=0.02, exposure=0.008)
    assert mean == pytest.approx(0.02 * (np.arange(480) / 479 - 0.5), abs=1e-6)


def test_a_moving_board_is_seen_where_the_moved_camera_sees_it():
    corners = BOARD.points_board()
    middle = corners.mean(axis=0)
    motion = HandMotion(np.array([0.1, -0.2, 0.3]), np.zeros(3))
    pose = CameraPose(np.eye(3), np.array([0.0, 0.0, -0.4]))
    later = moved(pose, motion, middle, 0.01)
    seen = (corners - later.position) @ later.rotation
    wanted = (corners + 0.01 * motion.velocity - pose.position) @ pose.rotation
    assert seen == pytest.approx(wanted, abs=1e-12)


def test_a_board_turns_about_its_middle():
    middle = BOARD.points_board().mean(axis=0)
    pose = CameraPose(np.eye(3), np.array([0.0, 0.0, -0.4]))
    later = moved(pose, HandMotion(np.zeros(3), np.array([0.5, 1.0, -2.0])), middle, 0.02)
    assert (middle - later.position) @ later.rotation == pytest.approx(middle - pose.position, abs=1e-12)


def test_the_board_is_held_whole_in_the_picture():
    rng, camera, corners = np.random.default_rng(4), nominal_robot().camera, BOARD.points_board()
    for _ in range(20):
        pose = held_pose(corners, camera, OperatorSettings(), rng)
        image = project(intrinsics_vector(camera), (corners - pose.position) @ pose.rotation)
        assert np.all((image > 0.0) & (image < [camera.width - 1.0, camera.height - 1.0]))


def test_a_fast_hand_blurs_the_picture():
    fast = OperatorSettings(fast_share=0.9, fast_factor=60.0)
    robot, rng = nominal_robot(), np.random.default_rng(1)
    quiet = HeldBoard(HandWork(robot, SensorSettings(), STILL, BOARD), rng)
    moving = HeldBoard(HandWork(robot, SensorSettings(), fast, BOARD), rng)
    widths = [
        [inspect_board(held.picture(), BOARD).edge_width_px for _ in range(8)] for held in (quiet, moving)
    ]
    assert np.nanmean(widths[1]) > 1.2 * np.nanmean(widths[0])


@pytest.fixture(scope="module")
def still_and_shaking():
    """Calibrations of one robot from boards held perfectly still and by a trembling hand."""
    robot = nominal_robot()
    shaking = replace(STILL, tremor_speed=0.05, tremor_rate=0.2)
    return robot, [
        calibrate_by_hand(HandWork(robot, SensorSettings(), each, BOARD), np.random.default_rng(7))
        for each in (STILL, shaking)
    ]


def test_boards_held_still_give_the_lens_to_half_a_pixel(still_and_shaking):
    robot, (still, _) = still_and_shaking
    assert projection_difference(still.same_solver.camera, robot.camera).rms < 0.5
    assert still.manual.figures.rms_px < 0.6


def test_a_trembling_hand_costs_accuracy(still_and_shaking):
    robot, both = still_and_shaking
    errors = [projection_difference(each.same_solver.camera, robot.camera).rms for each in both]
    assert errors[1] > 2.0 * errors[0]


def test_the_mount_is_read_from_a_board_on_the_floor():
    robot = nominal_robot()
    still = replace(STILL, board_offset_sd=0.0, board_turn_sd=0.0)
    work = HandWork(robot, SensorSettings(), still, BOARD)
    mount = mount_by_hand(work, robot.camera, np.random.default_rng(0))
    assert mount.pitch == pytest.approx(robot.mount.pitch, abs=0.003)
    assert mount.height == pytest.approx(robot.mount.height, abs=0.002)


@pytest.mark.parametrize("ratio", [0.85, 1.0, 1.15])
def test_a_person_brings_any_robot_within_about_the_manuals_criterion(ratio):
    robot = nominal_robot(wheel_ratio=ratio)
    wheels = calibrate_wheels_by_hand(robot, WorldSettings(), OperatorSettings(), np.random.default_rng(3))
    assert wheels.is_good
    assert abs(straight_deviation(robot.parameters(), wheels.wheel_ratio)) < 0.15
    assert all(drive.deviation == pytest.approx(round(drive.deviation, 2)) for drive in wheels.drives)


def test_trim_is_turned_against_the_drift():
    calm = OperatorSettings(feel_sd=0.0)
    right = adjusted_trim(TapeDrive(0.0, 2.0, 0.20), calm, np.random.default_rng(0))
    left = adjusted_trim(TapeDrive(0.0, 2.0, -0.20), calm, np.random.default_rng(0))
    assert ratio_of(right) > 1.0 > ratio_of(left)
    assert right == pytest.approx(-left)
