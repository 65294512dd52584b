"""The bias of a sub-pixel corner search under a curved lens, and its removal.

`cornerSubPix` looks for the point p whose offsets to the edge pixels q are at right angles to the gradients g
there: sum w g g' (q - p) = 0. On straight edges that is the corner. A lens bends the edges: at distance s
from the corner an edge of curvature kappa [1/px] lies kappa s^2 / 2 to one side while its normal n has turned
by kappa s, so that (with s = 0 at the corner) g' q = -n' g kappa s^2 / 2 and the solution moves by::

    b = -(sum w g g')^-1 sum w g (n' g) kappa s^2 / 2

w the search's weights exp(-(x^2 + y^2) / half^2) in its square window of half-width `half` [px], and each pixel
taken to the nearer of the two edges. The sums are taken over the picture's own gradients: how much of an edge
counts where depends on blur and light. Near the corner the two edges blot each other out, the more so where white
runs over; a formula for evenly sharp edges falls short by a sixth in large windows, by half in small ones, and by
more in glare. A hundredth of a pixel, but it points outward everywhere in the image, so that no number
of views averages it out. The curvature is read off the corners themselves: the middle of two neighbours is
kappa d^2 / 2 off the corner between them, d their distance [px] (d^2: the product of both distances where they differ).
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from fsm_calib.types import BoardSpec, FloatArray

_RIDGE = 1e-9
"""Keeps the sum of gradients invertible where a picture is flat, as a share of its trace."""


def curvature_bias(
    gray: NDArray[np.uint8], corners: FloatArray, halves: NDArray, board: BoardSpec
) -> FloatArray:
    """Return the bias of found corners, shape (n, 2) [px]: subtract it.

    Parameters
    ----------
    gray : array, shape (height, width), uint8
        The picture that they were found in.
    corners : array, shape (rows * columns, 2) [px]
    halves : array, shape (rows * columns,) [px]
        Half-window with which each was searched.
    board : BoardSpec
    """
    normals, curvatures = _bent_edges(corners, board)
    bias = np.empty_like(corners)
    for half in np.unique(halves):
        own = halves == half
        bias[own] = pull_of_edges(gray, corners[own], int(half), normals[own], curvatures[own])
    return bias


def expected_bias(corners: FloatArray, halves: NDArray, board: BoardSpec) -> FloatArray:
    """Return about how large the bias was before it was taken away, shape (n, 2) [px], without the picture.

    For edges that are evenly sharp to the corner, cut at the window: <s^2> is a quarter of half^2.
    """
    normals, curvatures = _bent_edges(corners, board)
    amounts = -curvatures * np.asarray(halves, dtype=float)[:, None] ** 2 / 8.0
    return np.asarray(np.linalg.solve(normals, amounts[..., None])[..., 0])


def _bent_edges(corners: FloatArray, board: BoardSpec) -> tuple[FloatArray, FloatArray]:
    """Return the unit normals (n, 2, 2) and curvatures (n, 2) [1/px] of the edges along the rows and the columns."""
    grid = corners.reshape(board.rows, board.columns, 2)
    rows, by_row = _edges(grid)
    columns, by_column = _edges(grid.transpose(1, 0, 2))
    normals = np.stack([rows, columns.transpose(1, 0, 2)], axis=2).reshape(-1, 2, 2)
    return normals, np.stack([by_row, by_column.T], axis=2).reshape(-1, 2)


def _edges(grid: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the edges along the rows: unit normals (rows, columns, 2) and curvatures (rows, columns) [1/px]."""
    chord = grid[:, 2:] - grid[:, :-2]
    normal = np.stack([-chord[..., 1], chord[..., 0]], axis=-1) / np.linalg.norm(chord, axis=-1)[..., None]
    sagitta = np.sum(normal * ((grid[:, 2:] + grid[:, :-2]) / 2.0 - grid[:, 1:-1]), axis=-1)
    spacing = np.linalg.norm(np.diff(grid, axis=1), axis=-1)
    curvature = 2.0 * sagitta / (spacing[:, 1:] * spacing[:, :-1])
    normal, curvature = _with_ends(normal), _with_ends(curvature[..., None])[..., 0]
    return normal / np.linalg.norm(normal, axis=-1)[..., None], curvature


def _with_ends(values: FloatArray) -> FloatArray:
    """Continue the columns by a straight line to both ends, which have one neighbour only."""
    if values.shape[1] < 2:
        return np.concatenate([values[:, :1], values, values[:, -1:]], axis=1)
    first, last = 2.0 * values[:, :1] - values[:, 1:2], 2.0 * values[:, -1:] - values[:, -2:-1]
    return np.concatenate([first, values, last], axis=1)


def pull_of_edges(
    gray: NDArray[np.uint8], corners: FloatArray, half: int, normals: FloatArray, curvatures: FloatArray
) -> FloatArray:
    """Return the bias of corners that were searched in one window, shape (m, 2) [px]; see the module.

    Parameters
    ----------
    gray : array, shape (height, width), uint8
    corners : array, shape (m, 2) [px]
    half : int
        Half-window [px].
    normals : array, shape (m, 2, 2)
        Unit normal (x, y) of either edge, a quarter turn from its direction t towards y: t = (n_y, -n_x).
    curvatures : array, shape (m, 2) [1/px]
        Of either edge, towards its normal.
    """
    gradient = _gradients(gray, corners, half)
    reach = np.arange(-half, half + 1.0)
    place = np.stack(np.meshgrid(reach, reach), axis=-1).reshape(-1, 2)
    weight = np.exp(-np.sum((place / half) ** 2, axis=1))
    along = np.stack([normals[..., 1], -normals[..., 0]], axis=-1) @ place.T
    steepness = gradient @ normals.transpose(0, 2, 1)
    off = -0.5 * curvatures[..., None] * along**2 * steepness.transpose(0, 2, 1)
    is_first = np.diff(np.abs(normals @ place.T), axis=1)[:, 0] > 0.0
    moved = np.where(is_first, off[:, 0], off[:, 1])
    weighted = gradient * weight[:, None]
    matrix = weighted.transpose(0, 2, 1) @ gradient
    matrix += (_RIDGE * (1.0 + np.trace(matrix, axis1=1, axis2=2)))[:, None, None] * np.eye(2)
    sums = (weighted * moved[..., None]).sum(axis=1)
    return np.asarray(np.linalg.solve(matrix, sums[..., None])[..., 0])


def _gradients(gray: NDArray[np.uint8], corners: FloatArray, half: int) -> FloatArray:
    """Return the gradients (m, (2 half + 1)^2, 2) around corners (m, 2), row by row of each window [grey levels]."""
    size = (2 * half + 3, 2 * half + 3)
    cut = [cv2.getRectSubPix(gray, size, (x, y), patchType=cv2.CV_32F) for x, y in corners.tolist()]
    patches = np.asarray(cut, dtype=float)
    right = patches[:, 1:-1, 2:] - patches[:, 1:-1, :-2]
    down = patches[:, 2:, 1:-1] - patches[:, :-2, 1:-1]
    return np.stack([right, down], axis=-1).reshape(len(corners), -1, 2)
