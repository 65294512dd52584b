"""Duckietown's four coverage bars: X, Y, size and skew of the boards in the images.

The same numbers as ROS's camera_calibration shows to a person who waves a board, computed for any set of
views. With A the board's area [px^2], W and H the image's sides [px], x and y the mean of the corners [px]::

    p_x = (x - sqrt(A) / 2) / (W - sqrt(A)),  p_y alike,  p_size = sqrt(A / (W H)),
    p_skew = min(1, 2 |pi/2 - angle at the upper right corner|)

A bar is (max - min) / range with ranges 0.7, 0.7, 0.4, 0.5; size and skew count from zero.
Source: ros-perception/image_pipeline, camera_calibration/calibrator.py (get_parameters, compute_goodenough).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from fsm_calib.types import BoardSpec, BoardView, FloatArray

_RANGES = (0.7, 0.7, 0.4, 0.5)  # x, y, size, skew; calibrator.py, `param_ranges`


@dataclass(frozen=True, slots=True)
class Coverage:
    """The four bars, each from 0 to 1 (full)."""

    x: float
    y: float
    size: float
    skew: float


def view_parameters(view: BoardView, board: BoardSpec, image_size: tuple[int, int]) -> FloatArray:
    """Return (p_x, p_y, p_size, p_skew) of one view, each in [0, 1]."""
    up_left, up_right, down_right, down_left = _outer_corners(view, board)
    across, down = down_right - up_left, down_left - up_right
    area = abs(float(across[0] * down[1] - across[1] * down[0])) / 2.0
    border = math.sqrt(area)
    width, height = image_size
    centre = np.nanmean(view.corners_image, axis=0)
    p_x = (centre[0] - border / 2.0) / max(width - border, 1.0)
    p_y = (centre[1] - border / 2.0) / max(height - border, 1.0)
    first, second = up_left - up_right, down_right - up_right
    cosine = float(first @ second) / float(np.linalg.norm(first) * np.linalg.norm(second))
    skew = 2.0 * abs(math.pi / 2.0 - math.acos(min(max(cosine, -1.0), 1.0)))
    return np.array(
        [np.clip(p_x, 0, 1), np.clip(p_y, 0, 1), math.sqrt(area / (width * height)), min(1.0, skew)]
    )


def _outer_corners(
    view: BoardView, board: BoardSpec
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the corners of the smallest part of the grid that holds what was seen, from the upper left, clockwise.

    Where one of them was not seen itself, it is where a homography of the others puts it.
    """
    seen = np.isfinite(view.corners_image[:, 0])
    grid = view.corners_image.reshape(board.rows, board.columns, 2)
    rows, columns = np.nonzero(seen.reshape(board.rows, board.columns))
    low, high, left, right = rows.min(), rows.max(), columns.min(), columns.max()
    places = [(low, left), (low, right), (high, right), (high, left)]
    if all(np.isfinite(grid[place][0]) for place in places):
        first, second, third, fourth = (grid[place] for place in places)
        return first, second, third, fourth
    matrix, _ = cv2.findHomography(np.column_stack([columns, rows]).astype(float), view.corners_image[seen])
    wanted = np.array([[(column, row) for row, column in places]], dtype=float)
    first, second, third, fourth = cv2.perspectiveTransform(wanted, matrix)[0]
    return first, second, third, fourth


def coverage(views: Sequence[BoardView], board: BoardSpec, image_size: tuple[int, int]) -> Coverage:
    """Return the four bars of a set of views."""
    if not views:
        return Coverage(0.0, 0.0, 0.0, 0.0)
    values = np.array([view_parameters(view, board, image_size) for view in views])
    low, high = values.min(axis=0), values.max(axis=0)
    low[2:] = 0.0
    return Coverage(*(float(min((h - b) / r, 1.0)) for h, b, r in zip(high, low, _RANGES, strict=True)))
