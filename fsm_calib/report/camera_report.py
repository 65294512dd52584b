"""One self-contained page about a camera calibration: figures, numbers, and what was left out and why."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import jinja2
import numpy as np
from numpy.typing import NDArray

from fsm_calib.perception.calibration import CameraCalibration
from fsm_calib.perception.information import advice, weakest_region
from fsm_calib.perception.lens import INTRINSICS, intrinsics_vector
from fsm_calib.report.camera_figures import (
    coverage_bars,
    error_map,
    lens_curve,
    reach,
    residual_arrows,
    undistorted_view,
)
from fsm_calib.types import BoardSpec, BoardView

_GOOD_PX = 0.6  # predicted error of 30 careful hand-held views (parity), at 0.2 px of corner noise


def camera_report(
    calibration: CameraCalibration,
    views: Sequence[BoardView],
    board: BoardSpec,
    example: tuple[str, NDArray[np.uint8]] | None = None,
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
    """
    used = [views[index] for index in calibration.used]
    before, after = ("", "") if example is None else undistorted_view(calibration, example[1])
    template = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent), autoescape=True
    ).get_template("camera.html.j2")
    return template.render(
        c=calibration,
        board=board,
        advice=verdict(calibration),
        error_map=error_map(calibration),
        arrows=residual_arrows(calibration, used),
        reach=reach(calibration, used),
        bars=coverage_bars(calibration),
        curve=lens_curve(calibration),
        before=before,
        after=after,
        example="" if example is None else example[0],
        parameters=parameter_rows(calibration),
    )


def verdict(calibration: CameraCalibration) -> str:
    """Return what the calibration is good for, in one or two sentences."""
    error = calibration.predicted_map
    if error.rms <= _GOOD_PX:
        return (
            f"As good as a careful person's 30 views or better; least certain at the {weakest_region(error)}."
        )
    return advice(error)


def parameter_rows(calibration: CameraCalibration) -> list[tuple[str, str, str]]:
    """Return (name, value, standard deviation) of each intrinsic that the model has."""
    vector, deviation = intrinsics_vector(calibration.camera), calibration.parameter_deviation
    rows = []
    for name, value in zip(INTRINSICS, vector, strict=True):
        digits = 2 if name in ("fx", "fy", "cx", "cy") else 5
        if name in deviation:
            rows.append((name, f"{value:.{digits}f}", f"{deviation[name]:.{digits}f}"))
    return rows
