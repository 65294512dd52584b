"""Every board view has a pose of its own: the classic camera calibration as a bundle problem.

A view's pose takes board points X to the camera frame: X_c = R X + t [m]. A step (w, d) of its six local
unknowns turns and shifts it there: R <- exp(w) R, t <- exp(w) t + d, w [rad], d [m]; so dX_c/dw = -skew(X_c),
dX_c/dd = I.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from fsm_calib.perception.bundle import Linearized
from fsm_calib.perception.lens import project, project_with_derivatives, unproject
from fsm_calib.perception.rotations import rotation_from_vector, skew
from fsm_calib.types import FloatArray


@dataclass(frozen=True, eq=False)
class BoardPoses:
    """Intrinsics (12,), see `lens`, and the boards' poses in the camera: rotation (views, 3, 3), shift
    (views, 3) [m].
    """

    intrinsics: FloatArray
    rotation: FloatArray
    shift: FloatArray

    def points_camera(self, points_board: FloatArray) -> FloatArray:
        """Return the board points (n, 3) in the camera frame, shape (views, n, 3) [m]."""
        return points_board @ np.swapaxes(self.rotation, 1, 2) + self.shift[:, None, :]

    def taken(self, which: np.ndarray) -> BoardPoses:
        """Return the state of some of the views."""
        return replace(self, rotation=self.rotation[which], shift=self.shift[which])


def by_pose(points_camera: FloatArray, by_point: FloatArray) -> FloatArray:
    """Return the derivative of image points by a view's six pose unknowns, shape (views, 2 n, 6)."""
    turn = -by_point @ skew(points_camera)
    both = np.concatenate([turn, by_point], axis=-1)
    return both.reshape(both.shape[0], -1, 6)


@dataclass(frozen=True, eq=False)
class FreeBoards:
    """The problem: found corners, shape (views, n, 2) [px], of boards with corners (n, 3) [m]."""

    corners_image: FloatArray
    points_board: FloatArray

    def residuals(self, state: BoardPoses) -> FloatArray:
        """Return predicted minus found, shape (views, 2 n) [px]."""
        predicted = project(state.intrinsics, state.points_camera(self.points_board))
        return (predicted - self.corners_image).reshape(len(predicted), -1)

    def linearize(self, state: BoardPoses) -> Linearized:
        """Return residuals and derivatives: 12 shared unknowns, 6 local ones per view."""
        points = state.points_camera(self.points_board)
        predicted, by_point, by_intrinsics = project_with_derivatives(state.intrinsics, points)
        views = len(points)
        return Linearized(
            residual=(predicted - self.corners_image).reshape(views, -1),
            shared=by_intrinsics.reshape(views, -1, 12),
            local=by_pose(points, by_point),
            block=np.arange(views),
        )

    def shared(self, state: BoardPoses) -> FloatArray:
        """Return the 12 intrinsics."""
        return state.intrinsics

    def moved(self, state: BoardPoses, shared: FloatArray, local: FloatArray) -> BoardPoses:
        """Return the state after a step: shared (12,), local (views, 6)."""
        turn = rotation_from_vector(local[:, :3])
        shift = np.einsum("vij,vj->vi", turn, state.shift) + local[:, 3:]
        return BoardPoses(state.intrinsics + shared, turn @ state.rotation, shift)

    def taken(self, which: np.ndarray) -> FreeBoards:
        """Return the problem of some of the views."""
        return FreeBoards(self.corners_image[which], self.points_board)


def start_poses(intrinsics: FloatArray, corners_image: FloatArray, points_board: FloatArray) -> BoardPoses:
    """Return the poses that explain each view's corners with these intrinsics (infinitesimal plane-based
    solution).
    """
    rotations, shifts = [], []
    for corners in corners_image:
        rays = np.ascontiguousarray(unproject(intrinsics, corners))
        _, turns, centres, _ = cv2.solvePnPGeneric(
            points_board, rays, np.eye(3), None, flags=cv2.SOLVEPNP_IPPE
        )
        turn, shift = _best_in_front(turns, centres)
        rotations.append(rotation_from_vector(turn))
        shifts.append(shift)
    return BoardPoses(np.array(intrinsics, dtype=float), np.array(rotations), np.array(shifts))


def _best_in_front(turns: Sequence, shifts: Sequence) -> tuple[FloatArray, FloatArray]:
    """Return the first (best) solution in front of the camera."""
    for turn, shift in zip(turns, shifts, strict=True):
        if float(np.ravel(shift)[2]) > 0.0:
            return np.ravel(turn), np.ravel(shift)
    shift = np.ravel(shifts[0])
    return np.ravel(turns[0]), np.array([shift[0], shift[1], max(abs(float(shift[2])), 1e-2)])
