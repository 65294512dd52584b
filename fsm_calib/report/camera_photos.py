"""The photos of a camera calibration with what was found in them, the worst first."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from fsm_calib.perception.calibration import CameraCalibration
from fsm_calib.types import BoardView

MOST = 12
"""Photos shown, the worst first: more make the page slow and tell no more."""
WIDTH = 480
"""Width of a photo on the page [px]."""
ENLARGED = 30.0
"""Residuals are drawn so many times their length."""


@dataclass(frozen=True)
class Overlay:
    """One photo on the page.

    name, rms_px, retake; href : the photo, reduced, as a data URI; width, height [px] of the photo itself; marks :
    (x, y, end x, end y) of each corner [px], its residual enlarged.
    """

    name: str
    rms_px: float
    retake: bool
    href: str
    width: int
    height: int
    marks: list[list[float]]


def overlays(
    calibration: CameraCalibration, used: Sequence[BoardView], read: Callable[[str], NDArray[np.uint8]]
) -> list[Overlay]:
    """Return the worst photos with their corners; `used` are the views used, `read` gives the pixels of a source."""
    worst = np.argsort(-calibration.view_rms)[:MOST]
    return [_overlay(calibration, int(view), used[view], read(used[view].source)) for view in worst]


def _overlay(
    calibration: CameraCalibration, number: int, view: BoardView, image: NDArray[np.uint8]
) -> Overlay:
    residuals = calibration.residuals[number]
    kept = np.isfinite(residuals).all(axis=1)
    corners = view.corners_image[kept]
    marks = np.hstack([corners, corners + ENLARGED * residuals[kept]]).round(1).tolist()
    height, width = image.shape[:2]
    return Overlay(
        Path(view.source).name,
        float(calibration.view_rms[number]),
        number in calibration.worst_views,
        _reduced(image),
        width,
        height,
        marks,
    )


def _reduced(image: NDArray[np.uint8]) -> str:
    """Return a photo, grey or BGR, at the page's width as a data URI of a JPEG."""
    photo = Image.fromarray(image if image.ndim == 2 else np.ascontiguousarray(image[..., ::-1]))
    buffer = io.BytesIO()
    photo.resize((WIDTH, round(WIDTH * photo.height / photo.width))).save(buffer, "JPEG", quality=72)
    return "data:image/jpeg;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")
