"""AprilGrid: a grid of tag36h11, Kalibr's or others', found in part, its corners in the order of the print.

Kalibr numbers tags from the lower left, OpenCV from the upper left, and each draws a tag turned in its own way. The
places of the tags tell which: of the two numberings only one is no mirror image, and the middles of the tags tell where
each corner belongs. Tags that could not be read are looked for where those that were read put them, and are taken where
what is seen there is their code.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fsm_calib.perception.tags import tag_cells
from fsm_calib.types import FloatArray

Image = NDArray[np.uint8]
REFINE_SPACING = 0.6
"""Half the window in which a tag's corner is refined, in gaps between tags [1]."""
LARGEST_DOUBLED = 1000
"""Photos up to this size are searched for tags at twice their size [px]."""
APARTS = (0, 3, 5, 7)
"""Kalibr's tags touch the squares between them; the picture is also searched with its white grown so wide [px]."""
LIKE_ITS_CODE = 0.7
"""Correlation of a tag's cells with its code from which it is that tag [1]."""
CELL_PX = 6
"""Pixels along a cell when a tag is looked at straight on."""


@dataclass(frozen=True, slots=True)
class TagGrid:
    """Columns and rows of tags, and the gap between them in sides of a tag."""

    columns: int
    rows: int
    gap: float

    @property
    def count(self) -> int:
        """How many tags."""
        return self.columns * self.rows


def aprilgrid_points(gray: Image, grid: TagGrid) -> FloatArray:
    """Return the corners of a grid's tags, shape (4 columns rows, 2) [px], row by row; nan where none was found."""
    points = np.full((4 * grid.count, 2), np.nan)
    tags, border = _read_tags(gray, grid)
    for is_from_below in (True, False):
        placed = {_row_from_above(number, grid, is_from_below): corners for number, corners in tags.items()}
        frame = _frame(placed, grid) if len(placed) >= 3 else None
        if frame is None:
            continue
        placed = {number: _turned(corners, frame) for number, corners in placed.items()}
        for number, corners in (placed | _guessed(gray, placed, grid, is_from_below, border)).items():
            points[_corner_places(number, grid)] = corners
        break
    return points


def _corner_places(number: int, grid: TagGrid) -> list[int]:
    """Return where a tag's corners stand among the points: upper left, upper right, lower right, lower left."""
    row, column = divmod(number, grid.columns)
    around = ((0, 0), (0, 1), (1, 1), (1, 0))
    return [(2 * row + down) * 2 * grid.columns + 2 * column + right for down, right in around]


def _read_tags(gray: Image, grid: TagGrid) -> tuple[dict[int, FloatArray], int]:
    """Return the tags that can be read, by number, and the cells of their border: 2 (Kalibr's) or 1."""
    by_border: dict[int, dict[int, FloatArray]] = {2: {}, 1: {}}
    factor = 2 if max(gray.shape) <= LARGEST_DOUBLED else 1
    large = (
        cv2.resize(gray, None, fx=factor, fy=factor, interpolation=cv2.INTER_CUBIC) if factor > 1 else gray
    )
    for width in APARTS:
        apart = cv2.dilate(large, np.ones((width, width), np.uint8)) if width else large
        for border, tags in by_border.items():
            found = _tags_in(gray, np.asarray(apart, dtype=np.uint8), factor, border, grid)
            tags |= {number: corners for number, corners in found.items() if number not in tags}
        if max(len(tags) for tags in by_border.values()) == grid.count:
            break
    border = max(by_border, key=lambda cells: len(by_border[cells]))
    return by_border[border], border


def _guessed(
    gray: Image, placed: dict[int, FloatArray], grid: TagGrid, is_from_below: bool, border: int
) -> dict[int, FloatArray]:
    """Return the tags that were not read but are where the others put them."""
    known = np.vstack([_corners_drawn(number, grid) for number in placed])
    matrix, _ = cv2.findHomography(known, np.vstack(list(placed.values())))
    found: dict[int, FloatArray] = {}
    if matrix is None:
        return found
    for number in range(grid.count):
        if number in placed:
            continue
        quad = cv2.perspectiveTransform(_corners_drawn(number, grid)[None], matrix)[0]
        if np.any(quad < 4.0) or np.any(quad > np.array(gray.shape[::-1]) - 5.0):
            continue
        corners = _refined(gray, quad, grid.gap)
        if _is_tag(gray, corners, _row_from_above(number, grid, is_from_below), border):
            found[number] = corners
    return found


def _corners_drawn(number: int, grid: TagGrid) -> FloatArray:
    """Return a tag's corners in the drawing, shape (4, 2) [sides of a tag], x right, y down."""
    row, column = divmod(number, grid.columns)
    return np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]) + (1.0 + grid.gap) * np.array(
        [column, row]
    )


def _is_tag(gray: Image, corners: FloatArray, number: int, border: int) -> bool:
    """Tell whether what is seen between four corners is a tag's code, in any of its four turns."""
    code = np.pad(tag_cells(number), border - 1, constant_values=True)
    side = CELL_PX * len(code)
    straight = np.array([(0.0, 0.0), (side, 0.0), (side, side), (0.0, side)], dtype=np.float32) - 0.5
    matrix = cv2.getPerspectiveTransform(np.asarray(corners, dtype=np.float32), straight)
    seen = cv2.warpPerspective(gray, matrix, (side, side)).reshape(len(code), CELL_PX, len(code), CELL_PX)
    cells = seen.mean(axis=(1, 3))
    if cells.std() < 5.0:
        return False
    return max(_likeness(cells, np.rot90(~code, turn)) for turn in range(4)) > LIKE_ITS_CODE


def _likeness(cells: FloatArray, code: NDArray[np.bool_]) -> float:
    return float(np.corrcoef(cells.ravel(), code.ravel())[0, 1])


def _tags_in(gray: Image, apart: Image, factor: int, border: int, grid: TagGrid) -> dict[int, FloatArray]:
    """Return the tags seen in `apart`, `factor` times as large, their corners refined in the picture as it is."""
    parameters = cv2.aruco.DetectorParameters()
    parameters.markerBorderBits = border
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_NONE
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    quads, numbers, _ = cv2.aruco.ArucoDetector(dictionary, parameters).detectMarkers(apart)
    found: dict[int, FloatArray] = {}
    for number, quad in zip([] if numbers is None else np.ravel(numbers), quads, strict=True):
        if number < grid.columns * grid.rows:
            found[int(number)] = _refined(gray, (quad.reshape(4, 2) + 0.5) / factor - 0.5, grid.gap)
    return found


def _refined(gray: Image, quad: NDArray, gap: float) -> FloatArray:
    """Return a tag's corners to a tenth of a pixel."""
    side = float(np.linalg.norm(quad - np.roll(quad, 1, axis=0), axis=1).min())
    half = int(np.clip(REFINE_SPACING * min(gap, 0.5) * side, 3, 9))
    corners = np.ascontiguousarray(quad.reshape(-1, 1, 2), dtype=np.float32)
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 30, 0.005)
    return np.asarray(cv2.cornerSubPix(gray, corners, (half, half), (-1, -1), stop), float).reshape(4, 2)


def _row_from_above(number: int, grid: TagGrid, is_from_below: bool) -> int:
    row, column = divmod(number, grid.columns)
    return (grid.rows - 1 - row if is_from_below else row) * grid.columns + column


def _frame(placed: dict[int, FloatArray], grid: TagGrid) -> FloatArray | None:
    """Return the affine map (2, 3) from (column, row) to the image, None for a mirror image or tags in a line."""
    places = np.array([(number % grid.columns, number // grid.columns, 1.0) for number in placed])
    middles = np.array([corners.mean(axis=0) for corners in placed.values()])
    if np.linalg.matrix_rank(places) < 3:
        return None
    affine = np.linalg.lstsq(places, middles, rcond=None)[0].T
    return affine if np.linalg.det(affine[:, :2]) > 0.0 else None


def _turned(corners: FloatArray, frame: FloatArray) -> FloatArray:
    """Return a tag's corners begun at its upper left, clockwise."""
    middle = corners.mean(axis=0)
    wanted = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]) @ frame[:, :2].T
    scale = float(np.linalg.norm(corners - middle, axis=1).mean() / np.linalg.norm(wanted, axis=1).mean())
    errors = [float(np.linalg.norm(np.roll(corners, t, axis=0) - middle - scale * wanted)) for t in range(4)]
    return np.roll(corners, int(np.argmin(errors)), axis=0)
