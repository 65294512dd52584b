"""The classical calibration: OpenCV's corners and solver, as the tool of the Duckietown manual uses them.

It is what a calibration by hand is made with, and what the paper compares with. The robot's own calibration
(`intrinsics`) differs in how corners are refined, in leaving out views that do not agree, and in the choice
of the lens model.

Source: ROS `image_pipeline`, `camera_calibration/calibrator.py`: the window of the corner search is half the
smallest spacing, no corner lies within 8 px of the border; two radial and two tangential coefficients.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fsm_calib.errors import DataError
from fsm_calib.perception.board_order import canonical_order
from fsm_calib.perception.calibration import FitFigures, fit_figures
from fsm_calib.perception.chessboard import as_gray, smallest_spacing
from fsm_calib.types import BoardSpec, BoardView, CameraModel

BORDER_PX = 8.0
"""A board with a corner nearer to the border than this is not taken [px]."""
FEWEST_VIEWS = 4
"""Fewer views are refused."""
_FLAGS = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_FAST_CHECK
_STOP = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 30, 0.1)


@dataclass(frozen=True, eq=False)
class ClassicalCalibration:
    """A camera as OpenCV gives it, and its reprojection figures [px]."""

    camera: CameraModel
    figures: FitFigures


def classical_view(image: NDArray[np.uint8], board: BoardSpec) -> BoardView | None:
    """Return the board's corners in a grey or BGR image, or None where the manual's tool takes no sample."""
    gray = as_gray(image)
    found, rough = cv2.findChessboardCorners(gray, (board.columns, board.rows), flags=_FLAGS)
    if not found or rough is None:
        return None
    half = max(1, math.ceil(0.5 * smallest_spacing(rough.reshape(-1, 2).astype(float), board)))
    corners = cv2.cornerSubPix(gray, rough, (half, half), (-1, -1), _STOP).reshape(-1, 2).astype(float)
    far = np.array(gray.shape[::-1]) - 1.0 - BORDER_PX
    if np.any(corners < BORDER_PX) or np.any(corners > far):
        return None
    return BoardView(canonical_order(corners, gray, board))


def calibrate_classically(
    views: Sequence[BoardView], board: BoardSpec, image_size: tuple[int, int]
) -> ClassicalCalibration:
    """Return the camera that `cv2.calibrateCamera` finds.

    Parameters
    ----------
    views : sequence of BoardView
        As `classical_view` returns them.
    board : BoardSpec
    image_size : (width, height) [px]

    Raises
    ------
    DataError
        With fewer than `FEWEST_VIEWS` views.
    """
    if len(views) < FEWEST_VIEWS:
        raise DataError(f"{len(views)} views are too few, {FEWEST_VIEWS} are needed", cure="Take more views.")
    points = board.points_board().astype(np.float32)
    images = [view.corners_image.astype(np.float32).reshape(-1, 1, 2) for view in views]
    _, matrix, distortion, turns, shifts = cv2.calibrateCamera(
        [points] * len(views), images, image_size, None, None, flags=cv2.CALIB_FIX_K3
    )
    predicted = [
        cv2.projectPoints(points, turn, shift, matrix, distortion)[0] for turn, shift in zip(turns, shifts)
    ]
    residuals = np.stack([seen - drawn for seen, drawn in zip(images, predicted)]).reshape(len(views), -1, 2)
    lens = np.asarray(matrix, dtype=float), np.asarray(distortion, dtype=float).ravel()
    camera = CameraModel(*lens, width=image_size[0], height=image_size[1])
    return ClassicalCalibration(camera, fit_figures(residuals.astype(float)))
