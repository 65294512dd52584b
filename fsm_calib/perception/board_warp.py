r"""A board that is not flat: its sag across and along as two numbers, fitted with the camera.

    z = a (1 - u^2) + b (1 - v^2)

u, v in [-1, 1] across and along the points, a and b [m] how far the middle stands out (mrcal's two parameters). A bent
print moves the corners of near, tilted views by tenths of a pixel, the same way in all of them, and a fit that knows
only flat boards bends the lens for it. Each step takes a and b as shared unknowns beside the intrinsics, with every
view's pose eliminated (`bundle`), and then fits the camera again with the board as it is now.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fsm_calib.perception.bundle import Linearized, Solution, normal_equations
from fsm_calib.perception.free_boards import BoardPoses, FreeBoards
from fsm_calib.perception.lens import project_with_derivatives
from fsm_calib.types import FloatArray


@dataclass(frozen=True, slots=True)
class BoardWarp:
    """How far the middle of a board stands out of its rim across its columns and along its rows [m]."""

    across: float
    along: float


def warp_shapes(points_board: FloatArray) -> FloatArray:
    """Return the two shapes (1 - u^2, 1 - v^2) at the points (n, 3) of a board, shape (n, 2) [1]."""
    low, high = points_board[:, :2].min(axis=0), points_board[:, :2].max(axis=0)
    place = (2.0 * points_board[:, :2] - low - high) / (high - low)
    return np.asarray(1.0 - place**2)


def warped(points_board: FloatArray, warp: BoardWarp) -> FloatArray:
    """Return the flat points (n, 3) of a board [m], bent."""
    bent = points_board.copy()
    bent[:, 2] = warp_shapes(points_board) @ (warp.across, warp.along)
    return bent


def warp_step(problem: FreeBoards, solution: Solution[BoardPoses], held: np.ndarray) -> FloatArray:
    """Return by how much a and b should change, shape (2,) [m]; `held` marks intrinsics that stay."""
    state = solution.state
    _, by_point, _ = project_with_derivatives(state.intrinsics, state.points_camera(problem.points_board))
    up = state.rotation[:, :, 2]  # the board's normal in the camera
    by_height = np.einsum("vnij,vj->vni", by_point, up)
    by_warp = by_height[..., None] * warp_shapes(problem.points_board)[None, :, None, :]
    linearized = solution.linearized
    shared = np.concatenate([linearized.shared, by_warp.reshape(len(up), -1, 2)], axis=2)
    both = Linearized(linearized.residual, shared, linearized.local, linearized.block)
    step, _ = normal_equations(both, solution.weights).step(np.append(held, [False, False]), 0.0)
    return step[-2:]
