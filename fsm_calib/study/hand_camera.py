"""A camera calibrated by hand: a board held before the camera, 30 views, solved by the same code as a scan.

The board is drawn fixed and the camera moves before it, which is the same picture. While the shutter is open
the hand moves: a tremor always, a fast motion now and then, which blurs. A view in which no board is found is
taken again, as the tool of the manual does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from fsm_calib.errors import DataError
from fsm_calib.perception.calibration import CameraCalibration
from fsm_calib.perception.chessboard import find_board
from fsm_calib.perception.extrinsics import FLOOR_BOARD_OFFSET, board_points_base, calibrate_extrinsics
from fsm_calib.perception.intrinsics import calibrate
from fsm_calib.perception.lens import intrinsics_vector, project, unproject
from fsm_calib.perception.rotations import BASE_FROM_OPTICAL, mount_from_pose, rotation_from_vector
from fsm_calib.study.operator import OperatorSettings
from fsm_calib.types import BoardSpec, BoardView, CameraModel, CameraMount, FloatArray, Pose2
from fsm_calib.world2d.camera import Renderer
from fsm_calib.world2d.fleet import RobotSpec
from fsm_calib.world2d.scene import BoardPlacement, SceneSpec
from fsm_calib.world2d.sensor import SensorSettings, expose
from fsm_calib.world2d.surfaces import board_points_world, build_scene

HELD = BoardPlacement(x=2.0, y=0.0, z=1.5, yaw=math.pi)
"""The board in its scene: only what the camera sees relative to it matters."""
EDGE_PX = 12.0
"""Corners nearer to the image's edge than this are not wanted [px]: the pattern must be whole in the picture."""
WIDEST_RAY = 1.6
"""Tangent of the widest angle off the optical axis at which a corner may lie [1]: 58 degrees, beyond the picture."""
LEAST_DEPTH = 0.05
"""Least distance of a corner in front of the camera [m]."""
MOST_ATTEMPTS = 4
"""Views taken per view wanted before the operator gives up."""
EXPOSURE_POSES = 5
"""Poses that are averaged while the shutter is open."""


@dataclass(frozen=True, eq=False)
class HandCalibration:
    """A calibration by hand: the solution and how many views had to be taken for it."""

    calibration: CameraCalibration
    attempts: int


def calibrate_by_hand(
    robot: RobotSpec,
    sensor: SensorSettings,
    operator: OperatorSettings,
    board: BoardSpec,
    rng: np.random.Generator,
) -> HandCalibration:
    """Return the camera that a person's views give.

    Parameters
    ----------
    robot : RobotSpec
        Whose true lens takes the pictures.
    sensor : SensorSettings
        Exposure, noise, focus.
    operator : OperatorSettings
    board : BoardSpec
    rng : numpy.random.Generator

    Raises
    ------
    DataError
        When the board is not found in enough of the pictures.
    """
    views, attempts = held_views(robot, sensor, operator, board, rng)
    size = (robot.camera.width, robot.camera.height)
    return HandCalibration(calibrate(views, board, size, is_duckiebot=True), attempts)


def held_views(
    robot: RobotSpec,
    sensor: SensorSettings,
    operator: OperatorSettings,
    board: BoardSpec,
    rng: np.random.Generator,
) -> tuple[list[BoardView], int]:
    """Return the views in which the board was found, and how many were taken; errors as `calibrate_by_hand`."""
    placement = replace(HELD, board=board)
    scene = build_scene(SceneSpec(boards=(placement,)), rng)
    corners = board_points_world(placement)
    views: list[BoardView] = []
    for attempt in range(MOST_ATTEMPTS * operator.views):
        mount = held_pose(corners, robot.camera, operator, rng)
        light = Renderer(scene, robot.camera, mount).light(hand_motion(operator, sensor.exposure, rng))
        view = find_board(expose(light, robot.camera, sensor, rng), board)
        if view is not None:
            views.append(replace(view, source=f"view {attempt}"))
        if len(views) == operator.views:
            return views, attempt + 1
    found = f"the board was found in {len(views)} of {MOST_ATTEMPTS * operator.views} pictures"
    raise DataError(found, cure="Hold the board nearer and more quietly, or check the focus.")


def held_pose(
    corners: FloatArray, camera: CameraModel, operator: OperatorSettings, rng: np.random.Generator
) -> CameraMount:
    """Draw where the camera is, as a mount on a robot at the origin, such that the board is whole in the picture.

    Parameters
    ----------
    corners : array, shape (n, 3) [m]
        The board's inner corners in the scene.
    camera : CameraModel
    operator : OperatorSettings
    rng : numpy.random.Generator
    """
    middle, lens = corners.mean(axis=0), intrinsics_vector(camera)
    size = np.array([camera.width, camera.height], dtype=float)
    while True:
        lean, turn = rng.uniform(0.0, operator.largest_tilt), rng.uniform(0.0, math.tau)
        tilt = rotation_from_vector(lean * np.array([0.0, math.cos(turn), math.sin(turn)]))
        roll = rotation_from_vector(np.array([rng.normal(0.0, operator.roll_sd), 0.0, 0.0]))
        rotation = tilt @ roll @ BASE_FROM_OPTICAL
        pixel = rng.uniform(EDGE_PX, size - EDGE_PX)
        aim = np.append(unproject(lens, pixel[None])[0], 1.0)
        distance = rng.uniform(operator.nearest, operator.farthest)
        position = middle - rotation @ (aim / np.linalg.norm(aim) * distance)
        if _is_whole((corners - position) @ rotation, lens, size):
            return mount_from_pose(rotation, position)


def _is_whole(points: FloatArray, lens: FloatArray, size: FloatArray) -> bool:
    """Tell whether points, shape (n, 3) [m] in the camera's frame, all fall well inside the picture."""
    if np.any(points[:, 2] < LEAST_DEPTH):
        return False
    if np.any(np.linalg.norm(points[:, :2] / points[:, 2:], axis=1) > WIDEST_RAY):
        return False
    image = project(lens, points)
    return bool(np.all((image > EDGE_PX) & (image < size - 1.0 - EDGE_PX)))


def hand_motion(operator: OperatorSettings, exposure: float, rng: np.random.Generator) -> list[Pose2]:
    """Return the poses of the moving hand while the shutter is open for `exposure` [s], relative to the middle."""
    factor = operator.fast_factor if rng.random() < operator.fast_share else 1.0
    speed = rng.normal(0.0, operator.tremor_speed, 2) * factor
    rate = rng.normal(0.0, operator.tremor_rate) * factor
    times = np.linspace(-0.5, 0.5, EXPOSURE_POSES) * exposure
    return [Pose2(float(speed[0] * t), float(speed[1] * t), float(rate * t)) for t in times]


def mount_by_hand(
    robot: RobotSpec,
    camera: CameraModel,
    sensor: SensorSettings,
    operator: OperatorSettings,
    board: BoardSpec,
    rng: np.random.Generator,
) -> CameraMount:
    """Return the mount that the manual's extrinsic calibration gives: one picture of the board flat on the floor.

    Parameters
    ----------
    robot : RobotSpec
        Whose true lens and mount take the picture.
    camera : CameraModel
        The calibrated lens that is used to read it.
    sensor, operator, board, rng
        As in `calibrate_by_hand`; the robot is placed before the board by hand.

    Raises
    ------
    DataError
        When the board is not found or does not fit a floor.
    """
    middle = board_points_base(board, FLOOR_BOARD_OFFSET).mean(axis=0)
    placement = BoardPlacement(board, x=float(middle[0]), y=float(middle[1]), yaw=math.pi, lean=math.pi / 2.0)
    scene = build_scene(SceneSpec(boards=(placement,)), rng)
    x, y = rng.normal(0.0, operator.board_offset_sd, 2)
    place = Pose2(float(x), float(y), float(rng.normal(0.0, operator.board_turn_sd)))
    picture = expose(Renderer(scene, robot.camera, robot.mount).ideal(place), robot.camera, sensor, rng)
    return calibrate_extrinsics(picture, board, camera).mount
