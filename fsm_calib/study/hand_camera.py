"""A camera calibrated by hand: thirty views of a held board and the manual's tool; one picture for the mount.

The same pictures are also solved with the robot's own code, so that what the views are worth and what the
solver is worth can be told apart.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from fsm_calib.errors import DataError
from fsm_calib.perception.calibration import CameraCalibration
from fsm_calib.perception.chessboard import find_board
from fsm_calib.perception.classical import ClassicalCalibration, calibrate_classically, classical_view
from fsm_calib.perception.extrinsics import FLOOR_BOARD_OFFSET, board_points_base, calibrate_extrinsics
from fsm_calib.perception.intrinsics import calibrate
from fsm_calib.study.held_board import HandWork, HeldBoard
from fsm_calib.types import BoardSpec, BoardView, CameraModel, CameraMount, Pose2
from fsm_calib.world2d.camera import Renderer
from fsm_calib.world2d.scene import BoardPlacement, SceneSpec
from fsm_calib.world2d.sensor import expose
from fsm_calib.world2d.surfaces import build_scene

MOST_ATTEMPTS = 4
"""Pictures taken per view wanted before the operator gives up."""


@dataclass(frozen=True, eq=False)
class HandCalibration:
    """A calibration by hand.

    manual : what the manual's tool makes of the pictures; same_solver : what the robot's own code makes of
    them, None when it has no use for them; attempts : pictures that had to be taken.
    """

    manual: ClassicalCalibration
    same_solver: CameraCalibration | None
    attempts: int


def calibrate_by_hand(work: HandWork, rng: np.random.Generator) -> HandCalibration:
    """Return the camera that a person's views give.

    Raises
    ------
    DataError
        When the board is not found in enough of the pictures.
    """
    held, board, operator = HeldBoard(work, rng), work.board, work.operator
    manual: list[BoardView] = []
    own: list[BoardView] = []
    size = (work.robot.camera.width, work.robot.camera.height)
    for attempt in range(MOST_ATTEMPTS * operator.views):
        picture = held.picture()
        view = classical_view(picture, board)
        if view is None:
            continue
        manual.append(view)
        refined = find_board(picture, board)
        if refined is not None:
            own.append(replace(refined, source=f"picture {attempt}"))
        if len(manual) == operator.views:
            return HandCalibration(
                calibrate_classically(manual, board, size), _own_solution(own, board, size), attempt + 1
            )
    found = f"the board was found in {len(manual)} of {MOST_ATTEMPTS * operator.views} pictures"
    raise DataError(found, cure="Hold the board nearer and more quietly, or check the focus.")


def _own_solution(
    views: list[BoardView], board: BoardSpec, size: tuple[int, int]
) -> CameraCalibration | None:
    """Return what the robot's own code makes of a person's views; None when they are too few."""
    try:
        return calibrate(views, board, size, is_duckiebot=True)
    except DataError:
        return None


def mount_by_hand(work: HandWork, camera: CameraModel, rng: np.random.Generator) -> CameraMount:
    """Return the mount that the manual's extrinsic calibration gives: one picture of the board on the floor.

    The robot is placed before the board by hand; `camera` is the calibrated lens by which the picture is read.

    Raises
    ------
    DataError
        When the board is not found or does not fit a floor.
    """
    robot, operator, board = work.robot, work.operator, work.board
    middle = board_points_base(board, FLOOR_BOARD_OFFSET).mean(axis=0)
    placement = BoardPlacement(board, x=float(middle[0]), y=float(middle[1]), yaw=math.pi, lean=math.pi / 2.0)
    scene = build_scene(SceneSpec(boards=(placement,)), rng)
    x, y = rng.normal(0.0, operator.board_offset_sd, 2)
    place = Pose2(float(x), float(y), float(rng.normal(0.0, operator.board_turn_sd)))
    picture = expose(Renderer(scene, robot.camera, robot.mount).ideal(place), robot.camera, work.sensor, rng)
    return calibrate_extrinsics(picture, board, camera).mount
