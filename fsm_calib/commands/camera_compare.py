"""`fsm-calib calibrate-camera --compare`: how differently two cameras see, over the image."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fsm_calib.commands.files import check_places, tell_result, write_file
from fsm_calib.errors import InputError

if TYPE_CHECKING:
    from fsm_calib.perception.prediction import ImageError

_SHOWN = (5, 7)
"""Rows and columns of the difference that are printed."""


def compare_cameras(
    first: Path, second: Path, json_file: Path | None = None, report: Path | None = None
) -> None:
    """Tell how differently two cameras see the same rays over the image of the first [px], best rotation removed.

    Raises
    ------
    InputError
        A file that holds no camera, cameras of two sizes of image, or a place that cannot be written.
    """
    from fsm_calib.perception.camera_files import read_intrinsics
    from fsm_calib.perception.prediction import projection_difference

    check_places(json_file, report)
    cameras = (read_intrinsics(first), read_intrinsics(second))
    sizes = [(camera.width, camera.height) for camera in cameras]
    if sizes[0] != sizes[1]:
        said = " and ".join(f"{width}x{height}" for width, height in sizes)
        raise InputError(
            f"the images have {said} px", where="--compare", cure="Compare cameras of one image size."
        )
    apart = projection_difference(*cameras)
    plain = {"rms_px": apart.rms, "median_px": float(np.median(apart.grid)), "max_px": apart.max}
    names = (str(first), str(second))
    tell_result(plain | {"over_the_image_px": apart.grid.tolist()}, _words(names, apart), json_file)
    if report is not None:
        from fsm_calib.report.camera_compare import compare_page

        write_file(report, compare_page(names, cameras, apart))


def _words(names: tuple[str, str], apart: ImageError) -> str:
    """Return what a person wants to know: three figures, and where over the image."""
    rows, columns = (
        np.linspace(0, count - 1, shown).round().astype(int)
        for count, shown in zip(apart.grid.shape, _SHOWN, strict=True)
    )
    lines = [
        f"{names[0]} and {names[1]} differ by",
        f"  rms {apart.rms:.2f} px   median {np.median(apart.grid):.2f} px   at most {apart.max:.2f} px",
        "  over the image, from the upper left, best rotation removed [px]:",
    ]
    lines += ["  " + "".join(f"{value:9.2f}" for value in row) for row in apart.grid[np.ix_(rows, columns)]]
    return "\n".join(lines)
