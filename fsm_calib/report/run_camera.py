"""The camera: where corners were found, and what the fit leaves of them."""

from __future__ import annotations

import numpy as np

from fsm_calib.perception.calibration import CameraCalibration
from fsm_calib.report.run_record import RunRecord
from fsm_calib.report.run_style import BOARD_COLOURS, Margins, figure, svg


def coverage(record: RunRecord) -> str:
    """Return every corner of every view over the image as SVG, coloured by board."""
    width, height = record.notebook.image_size
    with figure(4.6, 3.6, Margins(top=0.42)) as fig:
        axes = fig.add_subplot()
        for board in sorted({view.board for view in record.notebook.views}):
            corners = np.vstack([view.corners_image for view in record.notebook.views if view.board == board])
            colour = BOARD_COLOURS[board % len(BOARD_COLOURS)]
            label = f"board {board}"
            axes.scatter(
                corners[:, 0], corners[:, 1], s=2.0, color=colour, label=label, linewidths=0, rasterized=True
            )
        axes.set(xlim=(0, width), ylim=(height, 0), xlabel="u [px]", ylabel="v [px]", aspect="equal")
        axes.legend(fontsize=8, markerscale=4, ncols=3, loc="upper center", bbox_to_anchor=(0.5, 1.14))
        return svg(fig, "Coverage of the image by corners")


def reprojection(calibration: CameraCalibration) -> str:
    """Return the reprojection errors of every corner as SVG [px]: a round cloud is noise alone."""
    residuals = calibration.residuals.reshape(-1, 2)
    residuals = residuals[np.isfinite(residuals).all(axis=1)]
    with figure(4.6, 3.6) as fig:
        axes = fig.add_subplot()
        axes.scatter(
            residuals[:, 0],
            residuals[:, 1],
            s=3.0,
            color="#2b7bba",
            alpha=0.35,
            linewidths=0,
            rasterized=True,
        )
        for radius, style in ((calibration.rms_px, "-"), (2.0 * calibration.rms_px, ":")):
            turn = np.linspace(0.0, 2.0 * np.pi, 90)
            axes.plot(
                radius * np.cos(turn), radius * np.sin(turn), color="#333333", linewidth=0.8, linestyle=style
            )
        reach = max(3.2 * calibration.rms_px, 1e-3)
        axes.set(
            xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal", xlabel="du [px]", ylabel="dv [px]"
        )
        axes.set_title(f"rms {calibration.rms_px:.3f} px")
        return svg(fig, "Reprojection errors")


def predicted_error(calibration: CameraCalibration) -> str:
    """Return the predicted projection error over the image as SVG [px]."""
    width, height = calibration.camera.width, calibration.camera.height
    with figure(4.6, 3.6) as fig:
        axes = fig.add_subplot()
        shown = axes.imshow(
            _map(calibration), extent=(0, width, height, 0), cmap="viridis", interpolation="bilinear"
        )
        fig.colorbar(shown, ax=axes, label="predicted error [px]", shrink=0.8)
        axes.set(xlabel="u [px]", ylabel="v [px]")
        return svg(fig, "Predicted error over the image")


def _map(calibration: CameraCalibration) -> np.ndarray:
    """Return the predicted error as a grid, rows from top to bottom."""
    return np.asarray(calibration.predicted_map.grid)
