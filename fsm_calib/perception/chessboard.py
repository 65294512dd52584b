"""Chessboard corners: 0.1 px down to squares of 8 px, one order, and a reason for every refusal.

The classic detector of OpenCV finds the grid; a sub-pixel search in a window that fits between the corners
refines it. The tutorial's window (11 px to each side) takes in the neighbour corners of small squares and
moves corners by up to 8 px; here every corner's half-window is 0.45 of the distance to its nearest neighbour,
3 to 9 px, and a board whose corners moved by more than 0.3 squares is refused.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from fsm_calib.perception.board_order import canonical_order
from fsm_calib.perception.corner_bias import curvature_bias
from fsm_calib.perception.corner_grid import straightened, unevenness
from fsm_calib.perception.corner_spacing import corner_clearances, corner_spacings, smallest_spacing
from fsm_calib.perception.edges import edge_width, enlargement
from fsm_calib.types import BoardSpec, BoardView, FloatArray

Image = NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class DetectorSettings:
    """How corners are searched for.

    Parameters
    ----------
    window_of_spacing : float
        Half-window of the sub-pixel search, in spacings of the corner's nearest neighbour [1]. Measured on
        boards of 9 px squares: 0.56 still gives 0.05 px, 0.67 takes in the neighbour and gives 0.2 px.
    smallest_window_px, largest_window_px : int
        Bounds of the half-window [px]: 3 keeps enough gradient, beyond 9 the lens bends the edges inside it.
    largest_move_squares : float
        A corner that the search moved farther than this from the detector's start is lost [squares].
    largest_stray_squares : float
        A corner that is farther than this from where its neighbours expect it stands out [squares]; asked only
        where a corner was lost.
    largest_unevenness : float
        The same for corners found on a second search [squares].
    border_px : float
        A board with a corner nearer to the image's border is refused as not whole [px]: half the search
        window would be missing.
    widest_edge_px : float
        A board whose black-white edges are wider (10 to 90 %) is refused as blurred [px in a 640 px wide image].
        OpenCV advises 3; a blurred corner stays unbiased, so the limit is where its noise has doubled.
    window_of_edge : float
        The half-window takes in an edge of a large photo up to so many of its widths [1].
    edge_of_spacing : float
        The same limit in smallest corner spacings [1]: small squares run into each other sooner.
    largest_side_px : int
        Larger photos are searched at this size first [px]; corners are refined in the full image.
    most_boards : int
        `find_boards` stops after so many.
    """

    window_of_spacing: float = 0.45
    smallest_window_px: int = 3
    largest_window_px: int = 9
    largest_move_squares: float = 0.3
    largest_stray_squares: float = 0.2
    largest_unevenness: float = 0.15
    border_px: float = 5.0
    widest_edge_px: float = 6.0
    window_of_edge: float = 2.0
    edge_of_spacing: float = 0.6
    largest_side_px: int = 1600
    most_boards: int = 8


DEFAULT_DETECTOR = DetectorSettings()
# One threshold from the histogram: 2 ms where a board is, 12 ms where none is. Adaptive thresholds take 90 ms to
# give up, and the detector's own quick look refuses boards that are small or lie flat.
_FAST = cv2.CALIB_CB_NORMALIZE_IMAGE
# Where that finds nothing, adaptive thresholds after the quick look: of 450 first looks of a fleet at a flat board, one
# threshold finds 414, the other way 432, either of them 440 (benchmarks/board_search.py --looks).
_SECOND = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_FAST_CHECK
_TWO_LOOKS = (_FAST, _SECOND)
_THOROUGH = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE
_LEAST_SIDE_PX = 15  # of less OpenCV makes no threshold, and no board is so small
_ANY_SIZE = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_LARGER
_STOP_SEARCH = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 30, 0.005)


@dataclass(frozen=True, eq=False)
class BoardFinding:
    """What was found in one image: a view, or the reason why there is none.

    view : the board's corners or None; refusal : one sentence, empty when there is a view; edge_width_px :
    width of the black-white edges (10 to 90 %) [px], nan when not measured.
    """

    view: BoardView | None
    refusal: str = ""
    edge_width_px: float = float("nan")


def as_gray(image: Image) -> Image:
    """Return `image` as one 8-bit channel, shape (height, width); BGR is converted."""
    return image if image.ndim == 2 else np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), dtype=np.uint8)


def find_board(
    image: Image, board: BoardSpec, settings: DetectorSettings = DEFAULT_DETECTOR
) -> BoardView | None:
    """Return the corners of a whole `board` in a grey or BGR image, or None: the fast path of a moving
    robot.
    """
    return inspect_board(image, board, settings=settings, thorough=False).view


def find_boards(
    image: Image, board: BoardSpec, settings: DetectorSettings = DEFAULT_DETECTOR
) -> tuple[BoardView, ...]:
    """Return every whole `board` in the image, from left to right.

    Each board found is painted over and the rest searched again, by one threshold only: where nothing is left
    the second look costs 60 ms. `BoardView.board` counts from the left.
    """
    found: list[BoardView] = []
    remaining = as_gray(image).copy()
    for _ in range(settings.most_boards):
        rough = _rough_corners(remaining, board, _TWO_LOOKS[: 1 if found else 2], settings)
        view = None if rough is None else _judged(remaining, rough, board, settings).view
        if view is None:
            break
        found.append(view)
        remaining = _painted_over(remaining, view.corners_image, board)
    found.sort(key=lambda view: float(view.corners_image[:, 0].mean()))
    return tuple(replace(view, board=index) for index, view in enumerate(found))


def inspect_board(
    image: Image, board: BoardSpec, *, settings: DetectorSettings = DEFAULT_DETECTOR, thorough: bool = True
) -> BoardFinding:
    """Return the board's corners or the reason for their absence.

    Parameters
    ----------
    image : array, shape (height, width) or (height, width, 3), uint8, BGR
    board : BoardSpec
    thorough : bool
        Search longer (no quick look first, then the sector-based detector), for photos rather than a live
        robot.
    """
    gray = as_gray(image)
    rough = _rough_corners(gray, board, (_THOROUGH,) if thorough else _TWO_LOOKS, settings)
    if rough is None and thorough:
        rough = _by_sectors(gray, board, settings)
    if rough is None:
        return BoardFinding(None, _why_nothing(gray, board))
    return _judged(gray, rough, board, settings)


def _judged(gray: Image, rough: FloatArray, board: BoardSpec, settings: DetectorSettings) -> BoardFinding:
    """Return the refined corners, or why they cannot be used."""
    corners = _refined(gray, rough, board, settings)
    if corners is None:
        return BoardFinding(
            None, "the corners cannot be told apart: the squares are too small or too blurred"
        )
    if float(_to_border(corners, gray).min()) < settings.border_px:
        return BoardFinding(None, "the board reaches over the image's border")
    corners = canonical_order(corners, gray, board)
    width = edge_width(gray, corners, board)
    share = settings.edge_of_spacing * smallest_spacing(corners, board)
    limit = max(min(settings.widest_edge_px * enlargement(gray), share), 3.0)
    wide = int(settings.window_of_edge * width) if width <= limit and enlargement(gray) > 1.0 else 0
    if wide > settings.largest_window_px:  # the whole edge belongs in the window
        wider = _refined_from(gray, corners, board, replace(settings, largest_window_px=wide))
        corners = corners if wider is None else wider
    if width > limit:
        return BoardFinding(
            None, f"the board is blurred: edges {width:.1f} px wide, at most {limit:.1f} px", width
        )
    return BoardFinding(BoardView(corners), "", width)


def board_size_in(image: Image) -> tuple[int, int] | None:
    """Return the inner corners (columns, rows) of whatever chessboard the image shows, or None: about 0.1
    s.
    """
    gray = as_gray(image)
    scale = min(1.0, DEFAULT_DETECTOR.largest_side_px / max(gray.shape))
    small = gray if scale == 1.0 else cv2.resize(gray, None, fx=scale, fy=scale)
    found, _, whole = cv2.findChessboardCornersSBWithMeta(small, (3, 3), _ANY_SIZE)
    return (int(whole.shape[1]), int(whole.shape[0])) if found else None


def _rough_corners(
    gray: Image, board: BoardSpec, looks: tuple[int, ...], settings: DetectorSettings
) -> FloatArray | None:
    """Return the corners as the classic detector sees them with the first of the flags `looks` that finds
    them.
    """
    small, scale = _within(gray, settings)
    if min(small.shape) < _LEAST_SIDE_PX:
        return None
    for flags in looks:
        found, corners = cv2.findChessboardCorners(small, (board.columns, board.rows), flags=flags)
        if found and corners is not None:
            return _at_full_size(corners, scale)
    return None


def _by_sectors(gray: Image, board: BoardSpec, settings: DetectorSettings) -> FloatArray | None:
    """Return the corners as the sector-based detector sees them, when they are those of the whole board."""
    small, scale = _within(gray, settings)
    size = (board.columns, board.rows)
    found, corners, whole = cv2.findChessboardCornersSBWithMeta(small, size, _ANY_SIZE)
    is_whole = found and corners is not None and whole.shape == (board.rows, board.columns)
    return _at_full_size(corners, scale) if is_whole else None


def _within(gray: Image, settings: DetectorSettings) -> tuple[Image, float]:
    """Return the image no larger than it is searched at, and its scale [1]."""
    scale = min(1.0, settings.largest_side_px / max(gray.shape))
    small = gray if scale == 1.0 else cv2.resize(gray, None, fx=scale, fy=scale)
    return np.asarray(small, dtype=np.uint8), scale


def _at_full_size(corners: NDArray, scale: float) -> FloatArray:
    return np.asarray((corners.reshape(-1, 2).astype(float) + 0.5) / scale - 0.5)


def _refined(
    gray: Image, rough: FloatArray, board: BoardSpec, settings: DetectorSettings
) -> FloatArray | None:
    """Return refined corners, or None when one of them ran away with every window tried.

    Where one ran away, the search begins once more from corners that their neighbours agree with, and so must those
    that it ends at.
    """
    corners = _refined_from(gray, rough, board, settings)
    if corners is not None:
        return corners
    straight = straightened(rough, board, settings.largest_stray_squares)
    again = None if straight is None else _refined_from(gray, straight, board, settings)
    is_even = again is not None and bool(unevenness(again, board).max() <= settings.largest_unevenness)
    return again if is_even else None


def _refined_from(
    gray: Image, rough: FloatArray, board: BoardSpec, settings: DetectorSettings
) -> FloatArray | None:
    """Return the corners searched around `rough`, or None when one of them ran away with every window tried."""
    spacing = corner_spacings(rough, board)
    halves = half_windows(rough, board, settings)
    halves = np.where(_to_border(rough, gray) > halves + 1, halves, settings.smallest_window_px)
    limit = settings.largest_move_squares * np.maximum(spacing, 5.0)
    corners = rough
    for shrink in (0, 2, 4):
        corners = _searched(gray, rough, np.maximum(halves - shrink, 3))
        if np.all(np.linalg.norm(corners - rough, axis=1) <= limit):
            return corners - curvature_bias(gray, corners, np.maximum(halves - shrink, 3), board)
    return None


def half_windows(
    corners: FloatArray, board: BoardSpec, settings: DetectorSettings = DEFAULT_DETECTOR
) -> NDArray[np.int_]:
    """Return the half-window in which each corner inside the image is searched, shape (n,) [px]."""
    widest = np.floor(settings.window_of_spacing * corner_clearances(corners, board)).astype(int)
    return np.clip(widest, settings.smallest_window_px, settings.largest_window_px)


def _searched(gray: Image, rough: FloatArray, halves: NDArray) -> FloatArray:
    """Return the saddle points nearest to `rough`, each searched in its own half-window [px]."""
    corners = rough.copy()
    for half in np.unique(halves):
        own, window = halves == half, (int(half), int(half))
        start = np.ascontiguousarray(rough[own].reshape(-1, 1, 2), dtype=np.float32)
        found = cv2.cornerSubPix(gray, start, window, (-1, -1), _STOP_SEARCH)
        corners[own] = found.reshape(-1, 2)
    return corners


def _to_border(points: FloatArray, gray: Image) -> FloatArray:
    """Return each point's distance from the image's border [px]."""
    far = np.array([gray.shape[1], gray.shape[0]]) - 1.0 - points
    return np.asarray(np.minimum(points, far).min(axis=1))


def _painted_over(gray: Image, corners: FloatArray, board: BoardSpec) -> Image:
    """Return a copy with the board, and a square around it, in the mean grey of the board."""
    grid = corners.reshape(board.rows, board.columns, 2)
    outline = np.array([grid[0, 0], grid[0, -1], grid[-1, -1], grid[-1, 0]])
    centre = outline.mean(axis=0)
    growth = 1.0 + 2.4 / (min(board.rows, board.columns) - 1)
    polygon = np.rint(centre + (outline - centre) * growth).astype(np.int32)
    # the median from the histogram: seven times faster than by sorting
    below = np.cumsum(cv2.calcHist([gray], [0], None, [256], [0, 256]), dtype=int)
    median = np.searchsorted(below, ((gray.size - 1) // 2, gray.size // 2), side="right").mean()
    return np.asarray(cv2.fillConvexPoly(gray.copy(), polygon, float(median)))


def _why_nothing(gray: Image, board: BoardSpec) -> str:
    """Return the most likely reason, in one sentence, why no board was found."""
    mean, spread = float(gray.mean()), float(gray.std())
    if spread < 8.0:
        return f"the image is almost uniform (mean {mean:.0f}, contrast {spread:.0f} of 255)"
    if float(np.mean(gray > 250)) > 0.5:
        return "the image is over-exposed: more than half of it is white"
    return f"no whole board of {board.columns}x{board.rows} inner corners was found"
