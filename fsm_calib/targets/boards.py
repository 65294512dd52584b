"""Chessboards to print: as the detector expects them, with a ruler along two sides and the number of the board."""

from __future__ import annotations

import math

from fsm_calib.errors import InputError
from fsm_calib.targets.sheet import (
    MARGIN,
    Outline,
    Point,
    Shape,
    Sheet,
    Words,
    draw_ruler,
    paper_size,
    rectangle,
)
from fsm_calib.types import BoardSpec
from fsm_calib.world2d.scene import BoardPlacement

MM = 1000.0
QUIET = 11.0
"""White border that the detector needs around the squares [mm]; a third of Duckietown's squares."""
RULER = 150
"""Length of the rulers [mm]."""


def dark_squares(board: BoardSpec, x: float, y: float) -> tuple[Outline, ...]:
    """Return the dark squares of a board whose lower left corner is at (x, y) [mm].

    A dark square is at the first inner corner's upper left, as everywhere in this project.
    """
    side = MM * board.square
    return tuple(
        rectangle(x + column * side, y + (board.rows - row) * side, side, side)
        for row in range(board.rows + 1)
        for column in range(board.columns + 1)
        if (row + column) % 2 == 0
    )


def inner_corners(board: BoardSpec, sheet: Sheet) -> list[Point]:
    """Return where the inner corners lie on the board's sheet [mm], row by row from the upper left."""
    x, y, side = *_corner(board, sheet), MM * board.square
    return [
        (x + (column + 1) * side, y + (board.rows - row) * side)
        for row in range(board.rows)
        for column in range(board.columns)
    ]


def board_sheets(boards: tuple[BoardPlacement, ...], paper: str) -> list[Sheet]:
    """Return one sheet for each board of an area.

    Raises
    ------
    InputError
        A board that the paper does not hold.
    """
    return [_board_sheet(placement, number, paper) for number, placement in enumerate(boards)]


def _board_sheet(placement: BoardPlacement, number: int, paper: str) -> Sheet:
    board = placement.board
    sheet = Sheet(*_page(board, paper))
    x, y = _corner(board, sheet)
    sheet.content.append(Shape(dark_squares(board, x, y)))
    _draw_rulers(sheet, x, y)
    lean, side = math.degrees(placement.lean), MM * board.square
    where = {"flat": "lies on the floor", "upright": "stands upright", "leaned": f"leans {lean:.0f}° back"}
    said = f"board {number} · {board.columns} x {board.rows} inner corners · squares {side:g} mm · "
    said += f"{where[placement.kind]} at x {placement.x:+.3f} m, y {placement.y:+.3f} m, "
    said += f"facing {math.degrees(placement.yaw) % 360:.0f}°"
    top = y + (board.rows + 1) * side
    sheet.content.append(
        Words(sheet.width - MARGIN, min(top + QUIET - 5.5, sheet.height - 5.0), said, 2.6, "right")
    )
    return sheet


def _draw_rulers(sheet: Sheet, x: float, y: float) -> None:
    """Draw rulers at the left and lower edge with what to do about them."""
    low = max(3.5, min(y - QUIET + 1.0, 5.0))
    draw_ruler(sheet, x, low, RULER)
    draw_ruler(sheet, 5.0, y, RULER, upright=True)
    advice = "print at 100 % (“actual size”): both rulers must measure 150 mm"
    sheet.content.append(Words(x + RULER + 6.0, low, advice, 2.6))


def _page(board: BoardSpec, paper: str) -> tuple[float, float]:
    """Return the sheet's size [mm], lying or upright, on which the board fits."""
    wide, high = ((count + 1) * MM * board.square + 2.0 * QUIET for count in (board.columns, board.rows))
    for lies in (wide >= high, wide < high):
        size = paper_size(paper, wide=lies)
        if wide <= size[0] and high <= size[1]:
            return size
    raise InputError(
        f"a board of {wide:.0f} x {high:.0f} mm with its border does not fit on {paper.upper()}",
        where="--paper",
        cure="Take a3, or smaller squares.",
    )


def _corner(board: BoardSpec, sheet: Sheet) -> Point:
    """Return the lower left corner of the squares in the sheet's middle [mm]."""
    side = MM * board.square
    return 0.5 * (sheet.width - (board.columns + 1) * side), 0.5 * (sheet.height - (board.rows + 1) * side)
