"""Every board view has a pose of its own: the classic camera calibration as a bundle problem.

A view's pose takes board points X to the camera frame: X_c = R X + t [m]. A step (w, d) of its six local
unknowns turns and shifts it there: R <- exp(w) R, t <- exp(w) t + d, w [rad], d [m]; so dX_c/dw = -skew(X_c),
dX_c/dd = I.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fsm_calib.perception.bundle import Linearized, corner_distances, fit
from fsm_calib.perception.lens import project, project_with_derivatives, unproject
from fsm_calib.perception.plane_poses import plane_poses
from fsm_calib.perception.rotations import rotation_from_vector, skew
from fsm_calib.types import FloatArray


@dataclass(frozen=True, eq=False)
class BoardPoses:
    """Intrinsics (12,) or (8,), see `lens`, and the boards' poses in the camera: rotation (views, 3, 3), shift
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
    """The problem: found corners, shape (views, n, 2) [px], of boards with corners (n, 3) [m].

    Corners that were not seen are nan in `corners_image`; their residuals are 0, and `seen` has a 0 for them.
    """

    corners_image: FloatArray
    points_board: FloatArray

    @property
    def seen(self) -> FloatArray:
        """1 for corners that were seen, 0 for the others, shape (views, n)."""
        return np.isfinite(self.corners_image[..., 0]).astype(float)

    def _off(self, predicted: FloatArray) -> FloatArray:
        """Return predicted minus found, shape (views, 2 n) [px]; 0 where nothing was seen."""
        off = predicted - self.corners_image
        return np.where(np.isfinite(off), off, 0.0).reshape(len(predicted), -1)

    def residuals(self, state: BoardPoses) -> FloatArray:
        """Return predicted minus found, shape (views, 2 n) [px]."""
        predicted = project(state.intrinsics, state.points_camera(self.points_board))
        return self._off(predicted)

    def linearize(self, state: BoardPoses) -> Linearized:
        """Return residuals and derivatives: the intrinsics as shared unknowns, 6 local ones per view."""
        points = state.points_camera(self.points_board)
        predicted, by_point, by_intrinsics = project_with_derivatives(state.intrinsics, points)
        views = len(points)
        return Linearized(
            residual=self._off(predicted),
            shared=by_intrinsics.reshape(views, -1, state.intrinsics.size),
            local=by_pose(points, by_point),
            block=np.arange(views),
        )

    def shared(self, state: BoardPoses) -> FloatArray:
        """Return the intrinsics."""
        return state.intrinsics

    def moved(self, state: BoardPoses, shared: FloatArray, local: FloatArray) -> BoardPoses:
        """Return the state after a step: shared (s,), local (views, 6)."""
        turn = rotation_from_vector(local[:, :3])
        shift = np.einsum("vij,vj->vi", turn, state.shift) + local[:, 3:]
        return BoardPoses(state.intrinsics + shared, turn @ state.rotation, shift)

    def taken(self, which: np.ndarray) -> FreeBoards:
        """Return the problem of some of the views."""
        return FreeBoards(self.corners_image[which], self.points_board)


def start_poses(
    intrinsics: FloatArray, corners_image: FloatArray, points_board: FloatArray, choice: int = 0
) -> BoardPoses:
    """Return the poses that explain each view's corners with these intrinsics (infinitesimal plane-based
    solution): the better of the two that a plane has (`choice` 0), or its mirror image (1).
    """
    rotations, shifts = [], []
    for corners in corners_image:
        seen = np.isfinite(corners[:, 0])
        rays = unproject(intrinsics, corners[seen])
        turn, shift = _in_front(plane_poses(points_board[seen], rays), choice)
        rotations.append(rotation_from_vector(turn))
        shifts.append(shift)
    return BoardPoses(np.array(intrinsics, dtype=float), np.array(rotations), np.array(shifts))


def fitted_poses(intrinsics: FloatArray, problem: FreeBoards) -> BoardPoses:
    """Return the poses that fit each view best with these intrinsics, from either of the two that a plane has.

    A tilted board near the image's border that is read with a wrong lens looks like its mirror image, and no
    small step leads from there.
    """
    kept, held = problem.seen, np.ones(intrinsics.size, dtype=bool)
    fits = []
    for choice in (0, 1):
        start = start_poses(intrinsics, problem.corners_image, problem.points_board, choice)
        fits.append(fit(problem, start, held, kept))
    unseen = np.where(kept > 0.0, 0.0, np.nan)
    off = [np.nanmedian(corner_distances(found.residual) + unseen, axis=1) for found in fits]
    first, second = (found.state for found in fits)
    is_mirrored = (off[1] < off[0])[:, None]
    rotation = np.where(is_mirrored[:, None], second.rotation, first.rotation)
    return replace(first, rotation=rotation, shift=np.where(is_mirrored, second.shift, first.shift))


def _in_front(poses: Sequence[tuple[FloatArray, FloatArray]], choice: int) -> tuple[FloatArray, FloatArray]:
    """Return the pose of this number among those in front of the camera, the last where there are fewer."""
    found = [pair for pair in poses if float(np.ravel(pair[1])[2]) > 0.0]
    if found:
        turn, shift = found[min(choice, len(found) - 1)]
        return np.ravel(turn), np.ravel(shift)
    turn, shift = (np.ravel(values) for values in poses[0])
    return turn, np.array([shift[0], shift[1], max(abs(float(shift[2])), 1e-2)])
