"""Photos as people have them: files, folders of files, videos. Each gives shots, read one by one.

A video is looked at in even steps of time; what its shots have in common is left to `worth_keeping`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from fsm_calib.errors import InputError
from fsm_calib.types import BoardView

PHOTOS = (".jpg", ".jpeg", ".png", ".bmp", ".pgm", ".tif", ".tiff", ".webp")
VIDEOS = (".mp4", ".avi", ".mov", ".mkv", ".m4v", ".webm", ".mjpeg")
SHOTS_OF_A_VIDEO = 120
"""Frames of a video that are looked at: some two seconds of search in each of them."""
LEAST_MOVE = 0.04
"""A frame of a video counts as another view when the board moved so far since the last one kept [image widths]."""
_MARK = "#"  # between a video's name and the number of its frame


@dataclass(frozen=True, slots=True)
class Shot:
    """One picture: a file, or a frame of a video (`frame` counts from 0)."""

    path: Path
    frame: int | None = None

    @property
    def source(self) -> str:
        """How results call it: the path, with ``#number`` for a frame of a video."""
        return str(self.path) if self.frame is None else f"{self.path}{_MARK}{self.frame}"


def is_video(path: Path) -> bool:
    """Tell whether a file is a video by its name."""
    return path.suffix.lower() in VIDEOS


def photo_files(paths: Sequence[Path]) -> list[Path]:
    """Return the files that are meant: each as given, a folder's photos and videos in the order of their names.

    Raises
    ------
    InputError
        A folder that holds none.
    """
    found: list[Path] = []
    for path in paths:
        if not path.is_dir():
            found.append(path)
            continue
        inside = [file for file in sorted(path.iterdir()) if file.suffix.lower() in PHOTOS + VIDEOS]
        if not inside:
            raise InputError(
                "holds no photo and no video", where=str(path), cure=f"Expected {', '.join(PHOTOS)}."
            )
        found += inside
    return found


def video_shots(path: Path) -> Iterator[tuple[Shot, NDArray[np.uint8]]]:
    """Yield up to `SHOTS_OF_A_VIDEO` frames of a video, grey, evenly spread.

    Raises
    ------
    InputError
        The file is no video that can be read.
    """
    video = cv2.VideoCapture(str(path))
    try:
        count = int(video.get(cv2.CAP_PROP_FRAME_COUNT))
        step = max(1, round(count / SHOTS_OF_A_VIDEO))
        number = 0
        while video.grab():
            if number % step == 0:
                is_read, image = video.retrieve()
                if is_read:
                    yield (
                        Shot(path, number),
                        np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), dtype=np.uint8),
                    )
            number += 1
    finally:
        video.release()
    if number == 0:
        raise InputError(
            "is no video that can be read", where=str(path), cure="Expected MP4, AVI, MOV or MKV."
        )


def read_frame(source: str) -> NDArray[np.uint8] | None:
    """Return the frame ``video#number`` in colour, or None when `source` names no frame of a video."""
    name, mark, number = source.rpartition(_MARK)
    if not mark or not number.isdigit() or not is_video(Path(name)):
        return None
    video = cv2.VideoCapture(name)
    try:
        video.set(cv2.CAP_PROP_POS_FRAMES, int(number))
        is_read, image = video.read()
    finally:
        video.release()
    return np.asarray(image, dtype=np.uint8) if is_read else None


def is_another_view(view: BoardView, last: BoardView | None, width: int) -> bool:
    """Tell whether a board moved far enough since the last view of a video that was kept."""
    if last is None:
        return True
    moved = np.linalg.norm(view.corners_image - last.corners_image, axis=1)
    moved = moved[np.isfinite(moved)]
    return not moved.size or float(moved.mean()) > LEAST_MOVE * width
