"""One self-contained page about a camera calibration: figures, numbers, and what was left out and why."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fsm_calib.perception.calibration import CameraCalibration
from fsm_calib.report.camera_figures import (
    coverage_bars,
    error_map,
    lens_curve,
    reach,
    residual_arrows,
    undistorted_view,
)
from fsm_calib.report.camera_photos import ENLARGED, overlays
from fsm_calib.report.camera_poses import poses
from fsm_calib.report.camera_words import parameter_rows, verdict
from fsm_calib.report.pages import page
from fsm_calib.types import BoardSpec, BoardView


def camera_report(
    calibration: CameraCalibration,
    views: Sequence[BoardView],
    board: BoardSpec,
    example: tuple[str, NDArray[np.uint8]] | None = None,
    read: Callable[[str], NDArray[np.uint8]] | None = None,
) -> str:
    """Return the page as HTML.

    Parameters
    ----------
    calibration : CameraCalibration
    views : sequence of BoardView
        All views that went in; `calibration.used` tells which were used.
    board : BoardSpec
    example : (name, image), optional
        A photo to show undistorted.
    read : callable, optional
        Gives the pixels of a view's source; then the worst photos are shown with their corners.
    """
    used = [views[index] for index in calibration.used]
    before, after = ("", "") if example is None else undistorted_view(calibration, example[1])
    return page(
        "camera.html.j2",
        c=calibration,
        overlays=[] if read is None else overlays(calibration, used, read),
        enlarged=ENLARGED,
        photos=photo_rows(calibration, used),
        board=board,
        advice=verdict(calibration),
        error_map=error_map(
            calibration.predicted_map,
            (calibration.camera.width, calibration.camera.height),
            "predicted error [px]",
            "Predicted projection error over the image",
        ),
        poses=poses(calibration, board),
        arrows=residual_arrows(calibration, used),
        reach=reach(calibration, used),
        bars=coverage_bars(calibration),
        curve=lens_curve(calibration),
        before=before,
        after=after,
        example="" if example is None else example[0],
        parameters=parameter_rows(calibration),
    )


def photo_rows(calibration: CameraCalibration, used: Sequence[BoardView]) -> list[tuple[str, str, int, bool]]:
    """Return (file, rms [px], corners, whether to take it again) of each photo used, the worst first."""
    seen = np.isfinite(calibration.residuals[..., 0]).sum(axis=1)
    worst = set(calibration.worst_views)
    order = np.argsort(-calibration.view_rms)
    return [
        (
            Path(used[view].source).name,
            f"{calibration.view_rms[view]:.3f}",
            int(seen[view]),
            int(view) in worst,
        )
        for view in order
    ]
