"""Photos of a chessboard from files: read them, find the board in each, and say why where it is missing.

What no camera calibration can repair is refused with one sentence: a file that is no image, photos of
different sizes, the same photo twice, another board than the one asked for.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from fsm_calib.errors import DataError, InputError
from fsm_calib.perception.calibration import DroppedView
from fsm_calib.perception.chessboard import DEFAULT_DETECTOR, DetectorSettings, board_size_in, inspect_board
from fsm_calib.perception.encoded import decoded
from fsm_calib.perception.grid_boards import Finder
from fsm_calib.perception.photo_sources import Shot, is_another_view, is_video, read_frame, video_shots
from fsm_calib.types import BoardSpec, BoardView

_SIZE_CHECKS = 2  # first photos in which the board's whole size is looked for: 0.1 s each
_MOST_SIZE_CHECKS = 8  # sizes looked at in all, among them photos in which the board was not found
_AGREEING_CHECKS = 2  # so many photos must show the same other board
_AGREEING_PARTS = 3  # and so many when it could be a part of the board that was asked for


@dataclass(frozen=True, eq=False)
class PhotoSet:
    """Boards found in photos.

    views : the boards, `source` holds the file; dropped : photos without one, and why; image_size : (width,
    height) [px]; edge_widths_px : per view, how blurred its edges are, 10 to 90 % [px].
    """

    views: tuple[BoardView, ...]
    dropped: tuple[DroppedView, ...]
    image_size: tuple[int, int]
    edge_widths_px: tuple[float, ...]


def read_photo(path: Path, *, colour: bool = False) -> NDArray[np.uint8]:
    """Return a photo, grey (height, width) or BGR (height, width, 3), as the sensor saw it (not turned by its
    tags).

    Raises
    ------
    InputError
        The file cannot be read or is no image.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(
            f"cannot be read: {error.strerror}", where=str(path), cure="Check the path."
        ) from error
    flags = (cv2.IMREAD_COLOR if colour else cv2.IMREAD_GRAYSCALE) | cv2.IMREAD_IGNORE_ORIENTATION
    image = decoded(data, flags)
    if image is None:
        raise InputError("is not an image", where=str(path), cure="Expected a JPEG or PNG photo.")
    return image


def find_in_photos(
    paths: Sequence[Path],
    board: BoardSpec,
    settings: DetectorSettings = DEFAULT_DETECTOR,
    finder: Finder | None = None,
) -> PhotoSet:
    """Return the boards found in photos and videos of one camera.

    `finder` finds boards other than chessboards. Of a video, frames in which the board has hardly moved since the
    last one kept are left out.

    Raises
    ------
    InputError
        A file is no image, two photos are the same, their sizes differ, or they show a board of another size.
    DataError
        No photo shows the board.
    """
    _refuse_twins([path for path in paths if not is_video(path)])
    views: list[BoardView] = []
    dropped, widths = [], []
    sizes: list[tuple[int, int]] = []
    shown: list[tuple[int, int]] = []
    for index, (shot, gray) in enumerate(_shots(paths)):
        sizes.append((gray.shape[1], gray.shape[0]))
        _refuse_other_size(paths[0], sizes[0], shot.path, sizes[-1])
        finding = inspect_board(gray, board, settings=settings) if finder is None else finder(gray)
        if finder is None and (
            index < _SIZE_CHECKS or (finding.view is None and len(shown) < _MOST_SIZE_CHECKS)
        ):
            shown += [size] if (size := board_size_in(gray)) else []
            _refuse_other_board(shown, board)
        if finding.view is None:
            dropped.append(DroppedView(index, shot.source, finding.refusal))
        elif shot.frame is None or is_another_view(finding.view, views[-1] if views else None, sizes[0][0]):
            views.append(replace(finding.view, source=shot.source))
            widths.append(finding.edge_width_px)
    if not views:
        is_missing = "no whole board" in dropped[0].reason
        raise DataError(
            f"none of {len(sizes)} photos shows a {board.columns}x{board.rows} board ({dropped[0].reason})",
            cure="Count the inner corners: one less than the squares, in each direction."
            if is_missing
            else "Take sharp, well lit photos with the whole board in them.",
        )
    return PhotoSet(tuple(views), tuple(dropped), sizes[0], tuple(widths))


def _shots(paths: Sequence[Path]) -> Iterator[tuple[Shot, NDArray[np.uint8]]]:
    """Yield every picture of files and videos, grey."""
    for path in paths:
        if is_video(path):
            yield from video_shots(path)
        else:
            yield Shot(path), read_photo(path)


def read_source(source: str) -> NDArray[np.uint8]:
    """Return the picture that a view came from, in colour: a file, or ``video#number``."""
    frame = read_frame(source)
    return read_photo(Path(source), colour=True) if frame is None else frame


def photos_in(folder: Path) -> Iterator[Path]:
    """Yield the JPEG and PNG files of a folder by name."""
    for path in sorted(folder.iterdir()):
        if path.suffix.lower() in (".jpg", ".jpeg", ".png", ".bmp", ".pgm"):
            yield path


def _refuse_twins(paths: Sequence[Path]) -> None:
    seen: dict[str, Path] = {}
    for path in paths:
        try:
            digest = hashlib.sha256(path.read_bytes()).hexdigest()
        except OSError as error:
            raise InputError(
                f"cannot be read: {error.strerror}", where=str(path), cure="Check the path."
            ) from error
        if digest in seen:
            raise InputError(
                f"is the same photo as {seen[digest]}",
                where=str(path),
                cure="A view counts once: leave one out.",
            )
        seen[digest] = path


def _refuse_other_size(first: Path, size: tuple[int, int], path: Path, other: tuple[int, int]) -> None:
    if size != other:
        raise InputError(
            f"is {other[0]}x{other[1]} px, but {first} is {size[0]}x{size[1]} px",
            where=str(path),
            cure="Calibrate photos of one camera at one size, not cropped.",
        )


def _refuse_other_board(shown: Sequence[tuple[int, int]], board: BoardSpec) -> None:
    """Refuse when photos agree on another board; a smaller one may be the asked one, cut by the image's
    border.
    """
    asked = (max(board.columns, board.rows), min(board.columns, board.rows))
    others = [(max(size), min(size)) for size in shown]
    for size in sorted({other for other in others if other != asked}):
        is_part = size[0] <= asked[0] and size[1] <= asked[1]
        if others.count(size) >= (_AGREEING_PARTS if is_part else _AGREEING_CHECKS):
            raise InputError(
                f"photos show a board of {size[0]}x{size[1]} inner corners, not {board.columns}x{board.rows}",
                where="--board",
                cure=f"Use --board {size[0]}x{size[1]}, or leave the photos of another board out.",
            )
