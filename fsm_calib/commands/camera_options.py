"""What `calibrate-camera` is asked: board, size of the lens model, form of the file."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fsm_calib.errors import InputError, UnknownNameError
from fsm_calib.types import BoardSpec, CameraModel

if TYPE_CHECKING:
    from fsm_calib.perception.grid_boards import BoardRequest
    from fsm_calib.perception.solve_settings import SolveSettings

BOARD_KINDS = (
    "chessboard",
    "charuco",
    "aprilgrid",
    "circles",
    "asymmetric_circles",
)  # as in perception.grid_boards
USUAL_FORM, USUAL_NAME = "ros", "camera"
"""Form of a camera's file and name of the camera in it where nobody says otherwise."""
BoardOption = Annotated[
    list[str] | None,
    typer.Option(
        help="COLUMNSxROWS: a chessboard's inner corners, ChArUco's squares, tags or circles.",
        metavar="9x6",
        show_default=False,
    ),
]
SquareOption = Annotated[
    float,
    typer.Option(
        metavar="METRES",
        help="Side of a square or tag, or pitch of circles [m]; it scales distances only.",
    ),
]
KindOption = Annotated[str, typer.Option(metavar="KIND", help=f"What is printed: {', '.join(BOARD_KINDS)}.")]
MarkerOption = Annotated[
    float | None,
    typer.Option(metavar="METRES", help="Side of a ChArUco marker [m]; 0.75 squares.", show_default=False),
]
DictionaryOption = Annotated[
    str | None,
    typer.Option(metavar="NAME", help="A ChArUco board's markers (default: DICT_4X4_1000)."),
]
GapOption = Annotated[
    float | None,
    typer.Option(metavar="SHARE", help="AprilGrid: gap between tags, in sides of a tag (default: 0.3)."),
]
CoefficientsOption = Annotated[
    int | None,
    typer.Option(metavar="N", help="Use so many (4, 5 or 8) and do not choose.", show_default=False),
]


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


def refuse_unwritten(out: Path | None, form: str | None, name: str | None, *, compares: bool) -> None:
    """Raise where something is said of a camera's file that is not written: by a comparison, or without `out`.

    Raises
    ------
    InputError
        The first such option, with the cure.
    """
    said = {"--out": out, "--format": form, "--name": name}
    option = next((option for option, value in said.items() if value is not None), None)
    if option is not None and compares:
        raise InputError("a comparison writes no camera", where=option, cure="Leave it out.")
    if option is not None and out is None:
        raise InputError("this is of the camera's file", where=option, cure="Give --out FILE, too.")


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
    texts: Sequence[str],
    square: float,
    kind: str,
    marker: float | None,
    gap: float | None,
    dictionary: str | None,
) -> BoardRequest:
    """Return the board that the options name; None leaves what is usual.

    Raises
    ------
    InputError
        As `parse_board`; an unknown kind, or a gap that no grid has.
    """
    from fsm_calib.perception.grid_boards import KINDS, BoardRequest

    named = next((one for one in KINDS if one == kind), None)
    if named is None:
        raise UnknownNameError("kind of board", kind, KINDS, where="--kind")
    for option, value, owner in (
        ("marker", marker, "charuco"),
        ("dictionary", dictionary, "charuco"),
        ("gap", gap, "aprilgrid"),
    ):
        if value is not None and owner != named:
            typer.echo(f"--{option} does nothing: it is of boards of the kind {owner}, not {named}", err=True)
    if gap is not None and not 0.0 < gap < 10.0:
        raise InputError(f"a gap of {gap} sides", where="--gap", cure="Kalibr's tagSpacing, such as 0.3.")
    smallest = 1 if named == "aprilgrid" else 3
    spec = parse_board(texts, square, smallest)
    usual = BoardRequest(named, spec.columns, spec.rows, square, marker)
    return replace(usual, gap=gap or usual.gap, dictionary=dictionary or usual.dictionary)


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
