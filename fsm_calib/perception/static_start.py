"""Where the static-board fit starts: the camera's tilt, the boards and the frames, from views solved one by
one.

The camera turns about the vertical only, so the rotations between its views of one board share one axis: the
vertical, seen by the camera. It gives pitch and roll; then frames and boards are placed one from another.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from fsm_calib.perception.rotations import BASE_FROM_OPTICAL, vector_from_rotation, yaw_rotation
from fsm_calib.perception.static_problem import camera_from_level
from fsm_calib.types import FloatArray, wrap_angle

_LEAST_TURN = math.radians(5.0)  # rotations smaller than this do not tell their axis
_LARGEST_LEAN_ERROR = math.radians(8.0)  # a view whose board leans otherwise by more shows another board
_LARGEST_HEIGHT_ERROR = 0.06  # m; alike for the board's height


@dataclass(frozen=True, eq=False)
class LevelPose:
    """A board in the levelled camera: rotation (3, 3), centre (3,) [m]."""

    rotation: FloatArray
    centre: FloatArray

    def half_turned(self) -> LevelPose:
        """Return the same board read from its other end: turned by half a turn about its own normal."""
        return LevelPose(self.rotation @ np.diag([-1.0, -1.0, 1.0]), self.centre)


@dataclass
class Placement:
    """What has been placed so far: boards (pose in the world) and frames (x, y, yaw), and which views are
    flipped.
    """

    boards: dict[int, LevelPose] = field(default_factory=dict)
    frames: dict[int, FloatArray] = field(default_factory=dict)
    flipped: dict[int, bool] = field(default_factory=dict)
    refused: dict[int, str] = field(default_factory=dict)
    anchors: list[int] = field(default_factory=list)


def vertical_in_camera(rotations: FloatArray, board: np.ndarray) -> FloatArray | None:
    """Return the vertical (up) as a unit vector of the camera frame, or None when the camera hardly turned.

    rotations : (views, 3, 3) board to camera; board : (views,) which board each shows.
    """
    total = np.zeros((3, 3))
    for number in np.unique(board):
        own = rotations[board == number]
        for other in own[:: max(1, len(own) // 12)]:
            turns = np.array([vector_from_rotation(turn @ other.T) for turn in own])
            turns = turns[np.linalg.norm(turns, axis=1) > _LEAST_TURN]
            total += turns.T @ turns
    if not total.any():
        return None
    axis = np.linalg.eigh(total)[1][:, 2]
    return axis if axis[1] < 0.0 else -axis


def tilt_from_vertical(upward: FloatArray) -> FloatArray:
    """Return (pitch, roll) [rad] of a camera that sees the vertical as `upward` (3,)."""
    box = BASE_FROM_OPTICAL @ upward
    return np.array(
        [-math.asin(min(max(float(box[0]), -1.0), 1.0)), math.atan2(float(box[1]), float(box[2]))]
    )


def level_poses(
    rotation: FloatArray, shift: FloatArray, tilt: FloatArray, middle: FloatArray
) -> list[LevelPose]:
    """Return the boards in the levelled camera, placed by their `middle` (3,) [m]."""
    level = camera_from_level(tilt).T
    return [LevelPose(level @ r, level @ (r @ middle + t)) for r, t in zip(rotation, shift, strict=True)]


def place_all(poses: Sequence[LevelPose], board: np.ndarray, frame: np.ndarray, may_flip: bool) -> Placement:
    """Return the placement of all frames and boards, in the order of the frames.

    A frame is placed by the boards in it that have a place; boards that are never seen together with placed
    ones start a group of their own, whose first board is an anchor.
    """
    placement, waiting = Placement(), list(range(len(poses)))
    while waiting:
        left = [view for view in waiting if not _placed(view, poses, board, frame, placement, may_flip)]
        if len(left) == len(waiting):
            first = left.pop(0)
            _start_group(first, poses, board, frame, placement)
        waiting = left
    return placement


def _start_group(
    view: int, poses: Sequence[LevelPose], board: np.ndarray, frame: np.ndarray, placement: Placement
) -> None:
    placement.frames[int(frame[view])] = np.zeros(3)
    placement.boards[int(board[view])] = poses[view]
    placement.flipped[view] = False
    placement.anchors.append(int(board[view]))


def _placed(
    view: int,
    poses: Sequence[LevelPose],
    board: np.ndarray,
    frame: np.ndarray,
    placement: Placement,
    may_flip: bool,
) -> bool:
    """Place what this view can place; return whether the view is dealt with."""
    number, moment = int(board[view]), int(frame[view])
    if number in placement.boards:
        choice = _best_choice(poses[view], number, moment, placement, may_flip)
        if choice is None:
            placement.refused[view] = f"it does not show board {number}: the board would have moved"
            return True
        placement.flipped[view], seen = choice
        placement.frames.setdefault(moment, _frame_of(seen, placement.boards[number]))
        return True
    if moment in placement.frames:
        place = placement.frames[moment]
        turn = yaw_rotation(float(place[2]))
        centre = turn @ poses[view].centre + np.array([place[0], place[1], 0.0])
        placement.boards[number] = LevelPose(turn @ poses[view].rotation, centre)
        placement.flipped[view] = False
        return True
    return False


def _frame_of(seen: LevelPose, placed: LevelPose) -> FloatArray:
    """Return (x, y, yaw) of the frame that sees a placed board as `seen`."""
    between = placed.rotation @ seen.rotation.T
    yaw = math.atan2(between[1, 0] - between[0, 1], between[0, 0] + between[1, 1])
    place = placed.centre - yaw_rotation(yaw) @ seen.centre
    return np.array([place[0], place[1], yaw])


def _best_choice(
    pose: LevelPose, number: int, moment: int, placement: Placement, may_flip: bool
) -> tuple[bool, LevelPose] | None:
    """Return whether the view is read from its other end, and its pose; None when it fits neither way."""
    placed, best = placement.boards[number], None
    near = _nearest_yaw(moment, placement)
    for flipped, seen in ((False, pose), (True, pose.half_turned()))[: 1 + may_flip]:
        frame = _frame_of(seen, placed)
        between = placed.rotation @ (yaw_rotation(float(frame[2])) @ seen.rotation).T
        lean = float(np.linalg.norm(vector_from_rotation(between)))
        if (
            lean > _LARGEST_LEAN_ERROR
            or abs(float(seen.centre[2] - placed.centre[2])) > _LARGEST_HEIGHT_ERROR
        ):
            continue
        turn = abs(wrap_angle(float(frame[2]) - near))
        if best is None or turn < best[0]:
            best = (turn, flipped, seen)
    return None if best is None else best[1:]


def _nearest_yaw(moment: int, placement: Placement) -> float:
    """Return the yaw of the placed frame nearest in number."""
    nearest = min(placement.frames, key=lambda number: abs(number - moment), default=None)
    return 0.0 if nearest is None else float(placement.frames[nearest][2])
