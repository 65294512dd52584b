"""What `calibrate-camera` is asked: board, size of the lens model, form of the file, two cameras to compare."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import typer

from fsm_calib.errors import InputError, UnknownNameError
from fsm_calib.types import BoardSpec, CameraModel

if TYPE_CHECKING:
    from fsm_calib.perception.grid_boards import BoardRequest
    from fsm_calib.perception.solve_settings import SolveSettings


def compare_cameras(first: Path, second: Path) -> None:
    """Print how differently two cameras see the same rays over the image of the first [px], best rotation removed."""
    from fsm_calib.perception.camera_files import read_intrinsics
    from fsm_calib.perception.prediction import projection_difference

    cameras = [read_intrinsics(path) for path in (first, second)]
    sizes = [(camera.width, camera.height) for camera in cameras]
    if sizes[0] != sizes[1]:
        said = " and ".join(f"{width}x{height}" for width, height in sizes)
        raise InputError(
            f"the images have {said} px", where="--compare", cure="Compare cameras of one image size."
        )
    apart = projection_difference(*cameras)
    grid = np.asarray(apart.grid)
    typer.echo(f"{first} and {second} differ by")
    typer.echo(f"  rms {apart.rms:.2f} px   median {np.median(grid):.2f} px   at most {apart.max:.2f} px")
    typer.echo("  over the image, from the upper left, best rotation removed [px]:")
    rows, columns = (
        np.linspace(0, count - 1, shown).round().astype(int) for count, shown in zip(grid.shape, (5, 7))
    )
    for row in grid[np.ix_(rows, columns)]:
        typer.echo("  " + "".join(f"{value:9.2f}" for value in row))


def solve_settings(coefficients: int | None) -> SolveSettings:
    """Return the settings of the fit of any camera's photos; with `coefficients` the lens of that size alone.

    Raises
    ------
    InputError
        A size that there is not.
    """
    from fsm_calib.perception.solve_settings import ANY_CAMERA, DEFAULT_SOLVE

    if coefficients is None:
        return ANY_CAMERA
    if coefficients not in DEFAULT_SOLVE.coefficients:
        raise InputError(f"{coefficients} coefficients", where="--coefficients", cure="Give 4, 5 or 8.")
    return replace(DEFAULT_SOLVE, coefficients=(coefficients,))


def camera_writer(form: str) -> Callable[[CameraModel, str, str], str]:
    """Return what writes a camera in a form of `camera_formats`.

    Raises
    ------
    UnknownNameError
        There is no such form.
    """
    from fsm_calib.perception.camera_formats import FORMATS

    if form not in FORMATS:
        raise UnknownNameError("format", form, FORMATS, where="--format")
    return FORMATS[form]


def parse_request(
    texts: Sequence[str], square: float, kind: str, marker: float | None, gap: float, dictionary: str
) -> BoardRequest:
    """Return the board that the options name.

    Raises
    ------
    InputError
        As `parse_board`; an unknown kind, or a gap that no grid has.
    """
    from fsm_calib.perception.grid_boards import KINDS, BoardRequest

    named = next((one for one in KINDS if one == kind), None)
    if named is None:
        raise UnknownNameError("kind of board", kind, KINDS, where="--kind")
    if not 0.0 < gap < 10.0:
        raise InputError(f"a gap of {gap} sides", where="--gap", cure="Kalibr's tagSpacing, such as 0.3.")
    smallest = 1 if named == "aprilgrid" else 3
    spec = parse_board(texts, square, smallest)
    return BoardRequest(named, spec.columns, spec.rows, square, marker, gap, dictionary)


def parse_board(texts: Sequence[str], square: float, smallest: int = 3) -> BoardSpec:
    """Return the board of ``--board COLUMNSxROWS`` and ``--square``.

    Raises
    ------
    InputError
        More than one board, not of the form, smaller than `smallest` each way, or no positive square.
    """
    if len(texts) > 1:
        raise InputError(
            f"{len(texts)} boards are given", where="--board", cure="Calibrate with one board at a time."
        )
    match = re.fullmatch(r"(\d+)[xX](\d+)", texts[0].strip())
    if match is None:
        raise InputError(
            f"{texts[0]!r} is no board", where="--board", cure="Expected COLUMNSxROWS, such as 9x6."
        )
    columns, rows = int(match[1]), int(match[2])
    if min(columns, rows) < smallest:
        raise InputError(
            f"a board of {columns}x{rows} is too small",
            where="--board",
            cure=f"Use {smallest}x{smallest} or larger.",
        )
    if not 0.0 < square < 10.0:
        raise InputError(f"a square of {square} m", where="--square", cure="Expected metres, such as 0.025.")
    return BoardSpec(columns, rows, square)
