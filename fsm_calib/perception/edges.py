"""How sharp a board's black-white edges are, and how many times larger than a robot's image a photo is."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from fsm_calib.types import BoardSpec, FloatArray

_ROBOT_WIDTH_PX = 640.0  # px; Duckietown's camera node, for which limits in pixels are given


def edge_width(gray: NDArray[np.uint8], corners: FloatArray, board: BoardSpec) -> float:
    """Return the mean width of the board's black-white edges, 10 to 90 % [px]; nan when it cannot be
    measured.
    """
    grid = corners.astype(np.float32).reshape(-1, 1, 2)
    figures = cv2.estimateChessboardSharpness(gray, (board.columns, board.rows), grid)[0]
    width = float(np.ravel(figures)[0])
    return width if width > 0.0 else float("nan")


def enlargement(gray: NDArray[np.uint8]) -> float:
    """Return how many times longer than a robot's image (640 px) this one is, at least 1 [1]."""
    return max(1.0, max(gray.shape) / _ROBOT_WIDTH_PX)
