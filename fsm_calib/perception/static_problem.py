"""Boards that never move, seen by a camera that only drives on a floor: the bundle problem.

Shared unknowns: 12 intrinsics, the camera's pitch and roll [rad], six per board. Local unknowns: x, y [m] and
yaw [rad] of each frame. A board point X goes to the camera by::

    X_w = R_b X + t_b                       world: z up, all camera centres at z = 0
    X_l = Rz(-yaw) (X_w - (x, y, 0))        levelled camera
    X_c = M X_l,  M = P' Rx(-roll) Ry(-pitch)

with P the axes of an untilted camera. The height of the camera over the floor is in the boards' heights: a
board that lies on the floor tells it. One board of every group of boards that are never seen together keeps
its place and yaw; without that the whole area could be turned and shifted.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fsm_calib.perception.bundle import Linearized
from fsm_calib.perception.lens import project, project_with_derivatives
from fsm_calib.perception.rotations import BASE_FROM_OPTICAL, rotation_from_vector, skew, tilt_rotation
from fsm_calib.types import FloatArray

TILTS = 2  # pitch and roll follow the 12 intrinsics among the shared unknowns
FIRST_BOARD = 12 + TILTS


@dataclass(frozen=True, eq=False)
class StaticState:
    """Intrinsics (12,), tilt (pitch, roll) [rad], boards in the world, frames (frames, 3): x, y [m], yaw
    [rad].
    """

    intrinsics: FloatArray
    tilt: FloatArray
    board_rotation: FloatArray
    board_shift: FloatArray
    frames: FloatArray


def camera_from_level(tilt: FloatArray) -> FloatArray:
    """Return M (3, 3) of pitch and roll [rad]."""
    return np.asarray((tilt_rotation(float(tilt[0]), float(tilt[1])) @ BASE_FROM_OPTICAL).T)


def _by_tilt(tilt: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return dM/dpitch and dM/droll, each (3, 3)."""
    pitch_back = rotation_from_vector(np.array([0.0, -tilt[0], 0.0]))
    roll_back = rotation_from_vector(np.array([-tilt[1], 0.0, 0.0]))
    axes = BASE_FROM_OPTICAL.T
    by_pitch = -axes @ roll_back @ skew(np.array([0.0, 1.0, 0.0])) @ pitch_back
    by_roll = -axes @ skew(np.array([1.0, 0.0, 0.0])) @ roll_back @ pitch_back
    return by_pitch, by_roll


def yaw_back(yaw: FloatArray) -> FloatArray:
    """Return Rz(-yaw), shape (..., 3, 3)."""
    vectors = np.zeros((*np.shape(yaw), 3))
    vectors[..., 2] = -np.asarray(yaw)
    return rotation_from_vector(vectors)


@dataclass(frozen=True, eq=False)
class StaticBoards:
    """The problem: corners (views, n, 2) [px], points (n, 3) [m]; which board and frame each view shows
    (views,).
    """

    corners_image: FloatArray
    points_board: FloatArray
    board: np.ndarray
    frame: np.ndarray

    @property
    def boards(self) -> int:
        """How many boards there are."""
        return int(self.board.max()) + 1

    def shared(self, state: StaticState) -> FloatArray:
        """Return the shared unknowns; boards count from zero since only steps of them are known."""
        return np.concatenate([state.intrinsics, state.tilt, np.zeros(6 * self.boards)])

    def _points(self, state: StaticState) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the points in the world and the levelled camera, (views, n, 3), and Rz(-yaw), (views, 3,
        3).
        """
        turned = self.points_board @ np.swapaxes(state.board_rotation[self.board], 1, 2)
        world = turned + state.board_shift[self.board][:, None]
        frames = state.frames[self.frame]
        place = np.concatenate([frames[:, :2], np.zeros((len(frames), 1))], axis=1)
        back = yaw_back(frames[:, 2])
        return world, (world - place[:, None]) @ np.swapaxes(back, 1, 2), back

    def residuals(self, state: StaticState) -> FloatArray:
        """Return predicted minus found, shape (views, 2 n) [px]."""
        _, level, _ = self._points(state)
        predicted = project(state.intrinsics, level @ camera_from_level(state.tilt).T)
        return (predicted - self.corners_image).reshape(len(predicted), -1)

    def linearize(self, state: StaticState) -> Linearized:
        """Return residuals and derivatives: 12 + 2 + 6 boards shared unknowns, 3 local ones per frame."""
        world, level, back = self._points(state)
        mounted = camera_from_level(state.tilt)
        predicted, by_point, by_intrinsics = project_with_derivatives(state.intrinsics, level @ mounted.T)
        views, by_level = len(world), by_point @ mounted
        by_world = by_level @ back[:, None]
        tilts = [np.einsum("vnij,jk,vnk->vni", by_point, turn, level) for turn in _by_tilt(state.tilt)]
        boards = np.zeros((*by_world.shape[:3], self.boards, 6))
        own = np.concatenate([-by_world @ skew(world), by_world], axis=-1)
        boards[np.arange(views), :, :, self.board] = own
        shared = np.concatenate(
            [by_intrinsics, np.stack(tilts, axis=-1), boards.reshape(*own.shape[:3], -1)], axis=-1
        )
        turned = np.stack([level[..., 1], -level[..., 0], np.zeros(level.shape[:2])], axis=-1)
        by_yaw = np.einsum("vnij,vnj->vni", by_level, turned)[..., None]
        local = np.concatenate([-by_world[..., :2], by_yaw], axis=-1)
        return Linearized(
            residual=(predicted - self.corners_image).reshape(views, -1),
            shared=shared.reshape(views, -1, shared.shape[-1]),
            local=local.reshape(views, -1, 3),
            block=self.frame,
        )

    def moved(self, state: StaticState, shared: FloatArray, local: FloatArray) -> StaticState:
        """Return the state after a step."""
        steps = shared[FIRST_BOARD:].reshape(-1, 6)
        turn = rotation_from_vector(steps[:, :3])
        return StaticState(
            intrinsics=state.intrinsics + shared[:12],
            tilt=state.tilt + shared[12:FIRST_BOARD],
            board_rotation=turn @ state.board_rotation,
            board_shift=np.einsum("bij,bj->bi", turn, state.board_shift) + steps[:, 3:],
            frames=state.frames + local,
        )
