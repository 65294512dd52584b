"""Corners of a chessboard that stand where their neighbours do not expect them.

Over the board, image coordinates change smoothly: with column c and row r scaled to [-1, 1],

    u(c, r) = sum of a_jk c^j r^k,  j + k <= 3    (and the same for v)

bends enough for perspective and lens. A detector that takes one wrong point of a far, flat row shows as a corner off
this surface. The surface is fitted to the least sum of distances (iteratively reweighted least squares: Huber,
Robust Statistics, 1981, section 7.8), which single wrong corners do not move.
"""

from __future__ import annotations

import numpy as np

from fsm_calib.perception.corner_spacing import corner_spacings
from fsm_calib.types import BoardSpec, FloatArray

DEGREE = 3
ROUNDS = 12
_SHARPEST = 0.05
"""Residual below which a corner gains no more weight [px]."""
_LEAST_SPACING = 5.0
"""Squares smaller than this are taken as so large where deviations are judged [px]."""
_MOST_STRAYS = 0.2
"""Share of a board's corners that may stand out [1]; where more do, the surface is not to be trusted."""


def expected_corners(corners: FloatArray, board: BoardSpec) -> FloatArray:
    """Return where a smooth surface through most of the corners expects each of them.

    Parameters
    ----------
    corners : array, shape (columns * rows, 2) [px]
        Row by row.
    board : BoardSpec

    Returns
    -------
    array, shape (columns * rows, 2) [px]
    """
    row, column = np.divmod(np.arange(board.columns * board.rows), board.columns)
    across, down = (2.0 * item / max(item.max(), 1) - 1.0 for item in (column, row))
    powers = [(j, k) for j in range(DEGREE + 1) for k in range(DEGREE + 1 - j)]
    terms = np.stack([across**j * down**k for j, k in powers], axis=1)
    weights = np.ones(len(corners))
    surface = corners
    for _ in range(ROUNDS):
        root = np.sqrt(weights)[:, None]
        found, *_ = np.linalg.lstsq(terms * root, corners * root, rcond=None)
        surface = terms @ found
        weights = 1.0 / np.maximum(np.linalg.norm(corners - surface, axis=1), _SHARPEST)
    return surface


def unevenness(corners: FloatArray, board: BoardSpec, expected: FloatArray | None = None) -> FloatArray:
    """Return how far each corner is from where the others expect it [distances to its nearest neighbour]."""
    expected = expected_corners(corners, board) if expected is None else expected
    spacing = np.maximum(corner_spacings(corners, board), _LEAST_SPACING)
    return np.asarray(np.linalg.norm(corners - expected, axis=1) / spacing)


def straightened(corners: FloatArray, board: BoardSpec, stray_squares: float) -> FloatArray | None:
    """Return the corners with those that stand out put where the others expect them; None where none or too many do.

    A classic detector places a corner of a far, flat row up to half a square off when two squares run together.

    Parameters
    ----------
    corners : array, shape (columns * rows, 2) [px]
    board : BoardSpec
    stray_squares : float
        How far from its place a corner must be to stand out [distances to its nearest neighbour].
    """
    expected = expected_corners(corners, board)
    strays = unevenness(corners, board, expected) > stray_squares
    if not 0 < np.count_nonzero(strays) <= _MOST_STRAYS * len(corners):
        return None
    return np.where(strays[:, None], expected, corners)
