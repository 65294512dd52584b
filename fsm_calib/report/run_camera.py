"""The camera: where corners were found, and what the fit leaves of them."""

from __future__ import annotations

import base64

import numpy as np

from fsm_calib.perception.calibration import CameraCalibration
from fsm_calib.perception.undistort import as_png
from fsm_calib.report.palette import BOARD_COLOURS, HEAT, INK, TEXT
from fsm_calib.report.plot import Axes, Box, figure
from fsm_calib.report.plot_scale import Scale
from fsm_calib.runner.record import RunRecord
from fsm_calib.types import FloatArray

SIZE = (360.0, 320.0)
BOX = Box(54.0, 36.0, 296.0, 236.0)
"""Size of a figure and place of its axes [px]."""
NARROW = Box(54.0, 36.0, 236.0, 236.0)
"""Place of axes beside which a colour bar stands [px]."""
LAYERS = 6
"""Parts that a cloud of dots is drawn in: where dots of several parts meet, it is darker."""


def coverage(record: RunRecord) -> str:
    """Return every corner of every view over the image as SVG, coloured by board."""
    width, height = record.notebook.image_size
    axes = Axes(BOX.shrunk((0.0, width), (height, 0.0)), (0.0, width), (height, 0.0))
    for board in sorted({view.board for view in record.notebook.views}):
        corners = np.vstack([view.corners_image for view in record.notebook.views if view.board == board])
        axes.dots(corners, BOARD_COLOURS[board % len(BOARD_COLOURS)], 1.6, label=f"board {board}")
    axes.frame("u [px]", "v [px]")
    return figure(*SIZE, "Coverage of the image by corners", axes)


def reprojection(calibration: CameraCalibration) -> str:
    """Return the reprojection errors of every corner as SVG [px]: a round cloud is noise alone."""
    residuals = calibration.residuals.reshape(-1, 2)
    residuals = residuals[np.isfinite(residuals).all(axis=1)]
    reach = max(3.2 * calibration.rms_px, 1e-3)
    ends = (-reach, reach)
    axes = Axes(BOX.shrunk(ends, ends), ends, ends)
    for layer in range(LAYERS):
        axes.dots(residuals[layer::LAYERS], BOARD_COLOURS[0], 2.2, 0.4)
    turn = np.linspace(0.0, 2.0 * np.pi, 90)
    circle = calibration.rms_px * np.column_stack([np.cos(turn), np.sin(turn)])
    axes.line(circle, INK, 1.2, label=f"rms {calibration.rms_px:.3f} px")
    axes.line(2.0 * circle, INK, 1.2, "1 4", "twice of it")
    axes.frame("du [px]", "dv [px]")
    return figure(*SIZE, "Reprojection errors", axes)


def predicted_error(calibration: CameraCalibration) -> str:
    """Return the predicted projection error over the image as SVG [px]."""
    width, height = calibration.camera.width, calibration.camera.height
    grid = np.asarray(calibration.predicted_map.grid)
    low, high = float(grid.min()), max(float(grid.max()), float(grid.min()) + 1e-6)
    axes = Axes(NARROW.shrunk((0.0, width), (height, 0.0)), (0.0, width), (height, 0.0))
    axes.image(heat_picture((grid - low) / (high - low)))
    axes.frame("u [px]", "v [px]", "predicted error [px]")
    return figure(*SIZE, "Predicted error over the image", axes, extra=[colour_bar(axes.box, low, high)])


def heat_picture(grid: FloatArray) -> str:
    """Return a grid of values in [0, 1], rows from top to bottom, as a URL that holds the picture."""
    stops = np.array([[int(colour[place : place + 2], 16) for place in (5, 3, 1)] for colour in HEAT])
    at = np.linspace(0.0, 1.0, len(HEAT))
    channels = [np.interp(_between(grid), at, channel) for channel in stops.T]
    picture = np.stack(channels, axis=-1).round().astype(np.uint8)
    return "data:image/png;base64," + base64.b64encode(as_png(picture)).decode("ascii")


def _between(grid: FloatArray, factor: int = 6) -> FloatArray:
    """Return a grid `factor` times finer, values between its points interpolated along both sides."""
    for _ in range(2):
        rows = np.arange(len(grid))
        fine = np.linspace(0.0, len(grid) - 1.0, factor * len(grid))
        grid = np.stack([np.interp(fine, rows, column) for column in grid.T])
    return grid


def colour_bar(beside: Box, low: float, high: float) -> str:
    """Return a bar of the colours of values from `low` to `high`, to the right of a box, as SVG."""
    scale = Scale(low, high, beside.top + beside.height, beside.top)
    left = beside.left + beside.width + 14.0
    stops = "".join(
        f'<stop offset="{n / (len(HEAT) - 1):.3f}" stop-color="{c}"/>' for n, c in enumerate(HEAT)
    )
    bar = f'<linearGradient id="heat" x1="0" y1="1" x2="0" y2="0">{stops}</linearGradient>'
    bar += f'<rect x="{left:.1f}" y="{beside.top:.1f}" width="12" height="{beside.height:.1f}" fill="url(#heat)"/>'
    for value, label in scale.ticks():
        bar += f'<text x="{left + 17:.1f}" y="{float(scale(value)) + 4:.1f}" fill="{TEXT}">{label}</text>'
    return bar
