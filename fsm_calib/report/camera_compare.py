"""One self-contained page about two cameras: how differently they see the same rays, over the image."""

from __future__ import annotations

import numpy as np

from fsm_calib.perception.lens import intrinsics_vector, names_of
from fsm_calib.perception.prediction import ImageError
from fsm_calib.report.camera_figures import error_map
from fsm_calib.report.camera_words import intrinsic_text
from fsm_calib.report.pages import page
from fsm_calib.types import CameraModel


def compare_page(names: tuple[str, str], cameras: tuple[CameraModel, CameraModel], apart: ImageError) -> str:
    """Return the page as HTML; `apart` is what `prediction.projection_difference` tells of the two cameras."""
    size = (cameras[0].width, cameras[0].height)
    return page(
        "camera_compare.html.j2",
        names=names,
        size=size,
        apart=apart,
        median=float(np.median(apart.grid)),
        map=error_map(apart, size, "difference [px]", "Difference of two cameras over the image"),
        parameters=_rows(cameras),
    )


def _rows(cameras: tuple[CameraModel, CameraModel]) -> list[tuple[str, str, str]]:
    """Return (name, of the first, of the second) of their lenses and of each intrinsic."""
    told = []
    for camera in cameras:
        vector = intrinsics_vector(camera)
        told.append({name: intrinsic_text(name, value) for name, value in zip(names_of(vector), vector)})
    names = dict.fromkeys(name for camera in told for name in camera)
    return [
        ("lens", cameras[0].model, cameras[1].model),
        *((name, told[0].get(name, ""), told[1].get(name, "")) for name in names),
    ]
