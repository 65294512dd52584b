"""How near the corners of a board lie to each other and to the next edge in the image: what bounds a search window."""

from __future__ import annotations

import numpy as np

from fsm_calib.types import BoardSpec, FloatArray


def corner_spacings(corners: FloatArray, board: BoardSpec) -> FloatArray:
    """Return each corner's distance from its nearest neighbour [px], shape (rows * columns,)."""
    grid = corners.reshape(board.rows, board.columns, 2)
    along = np.linalg.norm(np.diff(grid, axis=1), axis=-1)
    across = np.linalg.norm(np.diff(grid, axis=0), axis=-1)
    nearest = np.full((board.rows, board.columns), np.inf)
    nearest[:, :-1] = np.minimum(nearest[:, :-1], along)
    nearest[:, 1:] = np.minimum(nearest[:, 1:], along)
    nearest[:-1] = np.minimum(nearest[:-1], across)
    nearest[1:] = np.minimum(nearest[1:], across)
    return nearest.ravel()


def corner_clearances(corners: FloatArray, board: BoardSpec) -> FloatArray:
    """Return how near each corner the next edge runs [px], shape (rows * columns,).

    On a slanted board squares become sheared: the next parallel edge, at the height of the sheared square, is
    then much nearer than the next corner.
    """
    grid = corners.reshape(board.rows, board.columns, 2)
    along = np.asarray(np.gradient(grid, axis=1))
    across = np.asarray(np.gradient(grid, axis=0))
    area = np.abs(along[..., 0] * across[..., 1] - along[..., 1] * across[..., 0])
    longest = np.maximum(np.linalg.norm(along, axis=-1), np.linalg.norm(across, axis=-1))
    return np.minimum(corner_spacings(corners, board), (area / longest).ravel())


def smallest_spacing(corners: FloatArray, board: BoardSpec) -> float:
    """Return the smallest distance between neighbour corners [px]."""
    return float(corner_spacings(corners, board).min())
