"""What a camera calibration is good for, in words and rows of text: for the terminal and for the page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fsm_calib.perception.calibration import CameraCalibration
from fsm_calib.perception.information import weakest_region
from fsm_calib.perception.lens import intrinsics_vector, names_of

_GOOD_PX = 0.6  # expected error of 30 careful hand-held views (parity), at 0.2 px of corner noise


def verdict(calibration: CameraCalibration) -> str:
    """Return what the calibration is good for, in one or two sentences."""
    error = calibration.predicted_map
    if error.expected <= _GOOD_PX:
        return (
            f"As good as a careful person's 30 views or better; least certain at the {weakest_region(error)}."
        )
    region = weakest_region(error)
    return (
        f"The image is least certain at the {region} ({error.max:.1f} px): take views with the board there, near and "
        "tilted."
    )


def scan_verdict(camera: Mapping[str, Any]) -> str:
    """Return whether a run's scan reached the error asked for, and the advice where it did not; `camera` is that of
    result.json. Empty where nothing was asked for.
    """
    if camera.get("reached") is None:
        return ""
    figures = f"predicted error {camera['predicted_px']:.3f} px, {camera['target_px']:.3g} px asked for"
    if camera["reached"]:
        return f"Reached: {figures}; least certain at the {camera['weakest_part']}."
    return f"Not reached: {figures}. {camera['advice']}"


def parameter_rows(calibration: CameraCalibration) -> list[tuple[str, str, str]]:
    """Return (name, value, standard deviation) of each intrinsic that the model has."""
    vector, deviation = intrinsics_vector(calibration.camera), calibration.parameter_deviation
    rows = []
    for name, value in zip(names_of(vector), vector, strict=True):
        if name in deviation:
            rows.append((name, intrinsic_text(name, value), intrinsic_text(name, deviation[name])))
    return rows


def intrinsic_text(name: str, value: float) -> str:
    """Return an intrinsic with as many digits as tell: pixels two, coefficients of the lens five."""
    return f"{value:.{2 if name in ('fx', 'fy', 'cx', 'cy') else 5}f}"
