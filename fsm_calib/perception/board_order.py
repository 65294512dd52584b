"""One order of a chessboard's corners, whatever the detector returned.

A board of c x r inner corners looks the same after half a turn when c + r is even (7x5, 8x6); then only a
convention can choose: the row runs to the right of the image. When c + r is odd (9x6) the colours decide: the
square between the first four corners is black. The order is never a mirror image: rows run clockwise from
columns as seen.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fsm_calib.types import BoardSpec, FloatArray

_SAMPLE_RADIUS_PX = 1  # a square's brightness is the mean of 3x3 pixels at its centre


def is_half_turn_ambiguous(board: BoardSpec) -> bool:
    """Tell whether the board looks the same after half a turn (columns + rows even)."""
    return (board.columns + board.rows) % 2 == 0


def half_turned(corners: FloatArray) -> FloatArray:
    """Return the corners of the same board read from its other end, shape (n, 2)."""
    return np.ascontiguousarray(corners[::-1])


def canonical_order(corners: FloatArray, gray: NDArray[np.uint8], board: BoardSpec) -> FloatArray:
    """Return `corners`, shape (rows * columns, 2) [px], in the board's one order; see the module."""
    grid = corners.reshape(board.rows, board.columns, 2)
    if _turns_left(grid):
        grid = grid[:, ::-1] if board.columns != board.rows else grid.transpose(1, 0, 2)
    ordered = np.ascontiguousarray(grid.reshape(-1, 2))
    if is_half_turn_ambiguous(board):
        return ordered if _row_runs_right(grid) else half_turned(ordered)
    return ordered if _first_square_is_black(grid, gray) else half_turned(ordered)


def _turns_left(grid: FloatArray) -> bool:
    along, across = grid[0, -1] - grid[0, 0], grid[-1, 0] - grid[0, 0]
    return bool(along[0] * across[1] - along[1] * across[0] < 0.0)


def _row_runs_right(grid: FloatArray) -> bool:
    along = (grid[:, -1] - grid[:, 0]).mean(axis=0)
    return bool(along[0] > 0.0 or (along[0] == 0.0 and along[1] > 0.0))


def _first_square_is_black(grid: FloatArray, gray: NDArray[np.uint8]) -> bool:
    """Compare the squares of both colours over the whole board, so that no single square decides."""
    centres = (grid[:-1, :-1] + grid[1:, :-1] + grid[:-1, 1:] + grid[1:, 1:]) / 4.0
    parity = np.add.outer(np.arange(centres.shape[0]), np.arange(centres.shape[1])) % 2
    values = brightness_at(gray, centres.reshape(-1, 2)).reshape(parity.shape)
    return bool(values[parity == 0].mean() < values[parity == 1].mean())


def brightness_at(gray: NDArray[np.uint8], points: FloatArray) -> FloatArray:
    """Return the mean grey value of 3x3 pixels at each of `points`, shape (n, 2) [px] -> (n,)."""
    height, width = gray.shape
    reach = _SAMPLE_RADIUS_PX
    column = np.clip(np.rint(points[:, 0]).astype(int), reach, width - 1 - reach)
    row = np.clip(np.rint(points[:, 1]).astype(int), reach, height - 1 - reach)
    offsets = [(i, j) for i in range(-reach, reach + 1) for j in range(-reach, reach + 1)]
    return np.mean([gray[row + i, column + j].astype(float) for i, j in offsets], axis=0)
