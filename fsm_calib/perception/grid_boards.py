"""Boards other than chessboards: ChArUco, AprilGrid, symmetric and asymmetric circles, found whole or in part.

A found board is a `BoardView` like a chessboard's; points that were not seen are nan. What is asked for is counted as
its makers count it: ChArUco by squares (OpenCV), AprilGrid by tags (Kalibr), circles by circles along a row and rows
(OpenCV's 4x11). Circles' centres are those of their images: the bias by perspective, below 0.1 px for circles of 20 px,
is not taken off.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, get_args

import cv2
import numpy as np
from numpy.typing import NDArray

from fsm_calib.errors import InputError, UnknownNameError
from fsm_calib.perception.aprilgrid import TagGrid, aprilgrid_points
from fsm_calib.perception.chessboard import BoardFinding, as_gray, inspect_board
from fsm_calib.types import BoardSpec, BoardView, FloatArray

BoardKind = Literal["chessboard", "charuco", "aprilgrid", "circles", "asymmetric_circles"]
KINDS: tuple[BoardKind, ...] = get_args(BoardKind)
FEWEST_POINTS = 8
"""A part of a board with fewer points tells nothing that its noise does not drown."""
Image = NDArray[np.uint8]
Finder = Callable[[Image], BoardFinding]


@dataclass(frozen=True, slots=True)
class GridSpec(BoardSpec):
    """A grid of points that is no plain square grid.

    kind : `asymmetric_circles` (every second row shifted by half a pitch; `square` is half the pitch along a row) or
    `aprilgrid` (corners of tags of side `square`, `gap` sides between them; columns and rows count corners).
    """

    kind: BoardKind = "aprilgrid"
    gap: float = 0.3

    def points_board(self) -> FloatArray:
        """Points in the board's frame, shape (rows * columns, 3) [m], row by row, z = 0."""
        row, column = np.mgrid[0 : self.rows, 0 : self.columns].reshape(2, -1)
        if self.kind == "asymmetric_circles":
            x, y = 2.0 * column + row % 2, 1.0 * row
        else:
            pitch = 1.0 + self.gap
            x, y = (part // 2 * pitch + part % 2 for part in (column, row))
        return self.square * np.column_stack([x, y, np.zeros(x.size)])


@dataclass(frozen=True, slots=True)
class BoardRequest:
    """The board that a person asked for: its kind, its count as its makers count, sizes [m], names.

    marker : side of a ChArUco's markers [m], None for 0.75 of a square; gap : between an AprilGrid's tags, in sides of
    a tag (Kalibr's tagSpacing); dictionary : OpenCV's name of a ChArUco's markers.
    """

    kind: BoardKind
    columns: int
    rows: int
    square: float
    marker: float | None = None
    gap: float = 0.3
    dictionary: str = "DICT_4X4_1000"

    def spec(self) -> BoardSpec:
        """Return the points of the board."""
        if self.kind == "charuco":
            return BoardSpec(self.columns - 1, self.rows - 1, self.square)
        if self.kind == "aprilgrid":
            return GridSpec(2 * self.columns, 2 * self.rows, self.square, "aprilgrid", self.gap)
        if self.kind == "asymmetric_circles":
            return GridSpec(self.columns, self.rows, self.square, "asymmetric_circles")
        return BoardSpec(self.columns, self.rows, self.square)

    def finder(self) -> Finder:
        """Return what finds the board in an image.

        Raises
        ------
        UnknownNameError
            A dictionary that OpenCV has not.
        """
        if self.kind == "charuco":
            return _charuco_finder(self)
        if self.kind == "aprilgrid":
            grid = TagGrid(self.columns, self.rows, self.gap)
            return lambda image: found_in_part(aprilgrid_points(as_gray(image), grid), "AprilGrid")
        if self.kind == "chessboard":
            spec = self.spec()
            return lambda image: inspect_board(image, spec)
        return lambda image: _circles_in(as_gray(image), self)


def found_in_part(points: FloatArray, kind: str) -> BoardFinding:
    """Return a view with nan for what was not seen, or why there are too few points."""
    seen = int(np.isfinite(points[:, 0]).sum())
    if seen < FEWEST_POINTS or _is_a_line(points):
        return BoardFinding(None, f"no {kind}: {seen} of {len(points)} points found, {FEWEST_POINTS} needed")
    return BoardFinding(BoardView(points))


def _is_a_line(points: FloatArray) -> bool:
    """Tell whether the points that were seen lie on a line: they tell no pose."""
    seen = points[np.isfinite(points[:, 0])]
    spread = np.linalg.svd(seen - seen.mean(axis=0), compute_uv=False)
    return bool(spread[1] < 0.05 * spread[0])


def _charuco_finder(asked: BoardRequest) -> Finder:
    names = sorted(name for name in dir(cv2.aruco) if name.startswith("DICT_"))
    if asked.dictionary not in names:
        raise UnknownNameError("dictionary", asked.dictionary, names, where="--dictionary")
    marker = 0.75 * asked.square if asked.marker is None else asked.marker
    if not 0.0 < marker < asked.square:
        cure = "Give the side of a marker in metres, smaller than --square."
        raise InputError(f"a marker of {marker} m", where="--marker", cure=cure)
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, asked.dictionary))
    size, detectors = (asked.columns, asked.rows), []
    for is_old in (False, True):  # OpenCV before 4.6 began boards of even rows with the other colour
        board = cv2.aruco.CharucoBoard(size, asked.square, marker, dictionary)
        board.setLegacyPattern(is_old)
        detectors.append(cv2.aruco.CharucoDetector(board))

    def found(image: Image) -> BoardFinding:
        finding = _charuco_in(as_gray(image), detectors[0], asked)
        if finding.view is None:
            detectors.reverse()  # the other pattern, and that first from now on
            finding = _charuco_in(as_gray(image), detectors[0], asked)
        return finding

    return found


def _charuco_in(gray: Image, detector: cv2.aruco.CharucoDetector, asked: BoardRequest) -> BoardFinding:
    corners, numbers, _, _ = detector.detectBoard(gray)
    points = np.full(((asked.columns - 1) * (asked.rows - 1), 2), np.nan)
    if numbers is not None and corners is not None:
        points[np.ravel(numbers)] = np.reshape(corners, (-1, 2))
    return found_in_part(points, "ChArUco board")


def _circles_in(gray: Image, asked: BoardRequest) -> BoardFinding:
    is_symmetric = asked.kind == "circles"
    flags = cv2.CALIB_CB_SYMMETRIC_GRID if is_symmetric else cv2.CALIB_CB_ASYMMETRIC_GRID
    for inverted in (gray, 255 - gray):  # dark circles on white, or the other way
        for extra in (0, cv2.CALIB_CB_CLUSTERING):
            is_there, centres = cv2.findCirclesGrid(
                inverted, (asked.columns, asked.rows), flags=flags | extra
            )
            if is_there:
                return BoardFinding(BoardView(np.reshape(centres, (-1, 2)).astype(float)))
    return BoardFinding(None, f"no whole grid of {asked.columns}x{asked.rows} circles was found")
