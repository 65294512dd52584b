"""Where the static-board fit starts: the camera's tilt, the boards and the frames, from views solved one by
one.

The camera turns about the vertical only, so the rotations between its views of one board share one axis: the
vertical, seen by the camera. It gives pitch and roll; then frames and boards are placed one from another.

A robot that scans tells boards apart by counting, and miscounts where one of them is out of sight. So the axis is
the one that most rotations agree on, and a view is laid at the door of the board that it fits: by the board's lean
and height, and by where the robot would have to stand.
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
_MISFIT = "it does not show board {}: the board would have moved"
_AXIS_WITHIN = math.cos(math.radians(10.0))  # a turn of 5 degrees between two views tells its axis to about 4
_MOST_CANDIDATES = 60  # rotations that are tried as the common axis
_NEARER_BY = (
    0.2  # m; another board is believed where the robot would have moved so much less; a standpoint is 0.12 m
)


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
    """What has been placed so far: boards (pose in the world) and frames (x, y, yaw), which views are flipped and
    which board each shows, and the group of boards and frames: the anchor's number.
    """

    boards: dict[int, LevelPose] = field(default_factory=dict)
    frames: dict[int, FloatArray] = field(default_factory=dict)
    flipped: dict[int, bool] = field(default_factory=dict)
    shown: dict[int, int] = field(default_factory=dict)
    refused: dict[int, str] = field(default_factory=dict)
    anchors: list[int] = field(default_factory=list)
    board_group: dict[int, int] = field(default_factory=dict)
    frame_group: dict[int, int] = field(default_factory=dict)

    def keep_view(self, view: int, board: int, flipped: bool) -> None:
        """Note which board a view shows, and from which end it is read."""
        self.shown[view], self.flipped[view] = board, flipped

    def place_frame(self, moment: int, place: FloatArray, group: int) -> None:
        """Place a frame that has no place."""
        if moment not in self.frames:
            self.frames[moment], self.frame_group[moment] = place, group

    def place_board(self, number: int, pose: LevelPose, group: int) -> None:
        """Place a board."""
        self.boards[number], self.board_group[number] = pose, group

    def frame_near(self, moment: int, group: int | None = None) -> FloatArray | None:
        """Return (x, y, yaw) of the placed frame nearest in number, of one group or of any; None without one."""
        own = [number for number, other in self.frame_group.items() if group in (None, other)]
        nearest = min(own, key=lambda number: abs(number - moment), default=None)
        return None if nearest is None else self.frames[nearest]


def vertical_in_camera(rotations: FloatArray, board: np.ndarray) -> FloatArray | None:
    """Return the vertical (up) as a unit vector of the camera frame, or None when the camera hardly turned.

    rotations : (views, 3, 3) board to camera; board : (views,) which board each shows.
    """
    found = [np.zeros((0, 3))]
    for number in np.unique(board):
        own = rotations[board == number]
        for other in own[:: max(1, len(own) // 12)]:
            turns = np.array([vector_from_rotation(turn @ other.T) for turn in own])
            found.append(turns[np.linalg.norm(turns, axis=1) > _LEAST_TURN])
    turns = np.concatenate(found)
    if not len(turns):
        return None
    agreeing = turns[_agreement(turns)]
    axis = np.linalg.eigh(agreeing.T @ agreeing)[1][:, 2]
    return axis if axis[1] < 0.0 else -axis


def _agreement(turns: FloatArray) -> np.ndarray:
    """Return which rotation vectors (n, 3) [rad] share the axis that most of them have."""
    axes = turns / np.linalg.norm(turns, axis=1, keepdims=True)
    candidates = axes[:: max(1, len(axes) // _MOST_CANDIDATES)]
    agree = np.abs(candidates @ axes.T) > _AXIS_WITHIN
    return np.asarray(agree[int(np.argmax(agree.sum(axis=1)))])


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
    ones start a group of their own, whose first board is an anchor. A view that fits no board is refused at last.
    """
    placement, waiting = Placement(), list(range(len(poses)))
    while waiting:
        left = [view for view in waiting if not _placed(view, poses, board, frame, placement, may_flip)]
        if len(left) == len(waiting):
            new = [view for view in left if int(board[view]) not in placement.boards]
            if not new:
                placement.refused |= {view: _MISFIT.format(int(board[view])) for view in left}
                break
            _start_group(new[0], poses, board, frame, placement)
            left.remove(new[0])
        waiting = left
    return placement


def _start_group(
    view: int, poses: Sequence[LevelPose], board: np.ndarray, frame: np.ndarray, placement: Placement
) -> None:
    number = int(board[view])
    placement.place_frame(int(frame[view]), np.zeros(3), number)
    placement.place_board(number, poses[view], number)
    placement.keep_view(view, number, False)
    placement.anchors.append(number)


def _placed(
    view: int,
    poses: Sequence[LevelPose],
    board: np.ndarray,
    frame: np.ndarray,
    placement: Placement,
    may_flip: bool,
) -> bool:
    """Place what this view can place; return whether it has a place."""
    number, moment = int(board[view]), int(frame[view])
    if number in placement.boards:
        fit = _best_board(poses[view], number, moment, placement, may_flip)
        if fit is None:
            return False
        placement.keep_view(view, fit.board, fit.flipped)
        placement.place_frame(moment, fit.frame, placement.board_group[fit.board])
        return True
    if moment in placement.frames:
        place = placement.frames[moment]
        turn = yaw_rotation(float(place[2]))
        centre = turn @ poses[view].centre + np.array([place[0], place[1], 0.0])
        pose = LevelPose(turn @ poses[view].rotation, centre)
        placement.place_board(number, pose, placement.frame_group[moment])
        placement.keep_view(view, number, False)
        return True
    return False


@dataclass(frozen=True, eq=False)
class _Fit:
    """A view taken for a view of a placed board: read from which end, the frame (x, y, yaw) that follows, and how
    far that is from the nearest frame [m].
    """

    board: int
    flipped: bool
    frame: FloatArray
    jump: float


def _best_board(
    pose: LevelPose, number: int, moment: int, placement: Placement, may_flip: bool
) -> _Fit | None:
    """Return the view as one of its board; of another where it does not fit that, or the robot would have jumped."""
    fits = [_fit_to(other, pose, moment, placement, may_flip) for other in placement.boards]
    found = [fit for fit in fits if fit is not None]
    nearest = min(found, key=lambda fit: fit.jump, default=None)
    own = next((fit for fit in found if fit.board == number), None)
    return nearest if own is None or (nearest and nearest.jump < own.jump - _NEARER_BY) else own


def _fit_to(number: int, pose: LevelPose, moment: int, placement: Placement, may_flip: bool) -> _Fit | None:
    choice = _best_choice(pose, number, moment, placement, may_flip)
    if choice is None:
        return None
    frame = _frame_of(choice[1], placement.boards[number])
    near = placement.frame_near(moment, placement.board_group[number])
    jump = 0.0 if near is None else float(np.linalg.norm(frame[:2] - near[:2]))
    return _Fit(number, choice[0], frame, jump)


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
    place = placement.frame_near(moment)
    near = 0.0 if place is None else float(place[2])
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
