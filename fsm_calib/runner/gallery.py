"""Frames of a run, kept on disk for the report as soon as they are taken, so that a killed run loses none."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsm_calib.actions.bench import KeptFrame
from fsm_calib.perception.encoded import encode_jpeg

JPEG_QUALITY = 82
"""Quality of kept frames, 1 to 95: small, and corners still look like corners."""


@dataclass(frozen=True)
class Picture:
    """A kept frame.

    Parameters
    ----------
    file : str
        Path below the run's directory.
    time : float
        When it was taken, robot time [s].
    path : str
        The machine's state.
    activity : str
        What the robot was doing.
    sentence : str
        What it found.
    width, height : int
        Size [px].
    points : list of [x, y]
        What was found in it [px].
    """

    file: str
    time: float
    path: str
    activity: str
    sentence: str
    width: int
    height: int
    points: list[list[float]]


class Gallery:
    """Writes frames to ``frames/`` below the run's directory, about as many of each phase.

    Parameters
    ----------
    directory : Path
        The run's directory.
    most : int
        Frames kept of one phase; twice as many are collected, then every second one is dropped, so that the
        kept ones are spread over the phase however long it lasts.
    pictures : list of Picture
        Those kept before the run was resumed.
    """

    def __init__(self, directory: Path, most: int, pictures: list[Picture] | None = None) -> None:
        self._directory = directory
        self._most = most
        self.pictures = list(pictures or [])

    def add(self, kept: KeptFrame, path: str, sentence: str) -> None:
        """Write one frame and remember what was found in it."""
        if self._most < 1:
            return
        phase = path.split("/")[0]
        name = f"frames/{phase}-{round(kept.time * 1000.0):08d}.jpg"
        _write(self._directory / name, kept.image)
        height, width = kept.image.shape[:2]
        points = [[round(float(x), 2), round(float(y), 2)] for x, y in kept.points_image.reshape(-1, 2)]
        self.pictures.append(Picture(name, kept.time, path, kept.activity, sentence, width, height, points))
        self._thin(phase)

    def _thin(self, phase: str) -> None:
        """Drop every second picture of a phase that has too many."""
        same = [picture for picture in self.pictures if picture.path.split("/")[0] == phase]
        if len(same) < 2 * self._most:
            return
        dropped = same[1::2]
        self.pictures = [picture for picture in self.pictures if picture not in dropped]
        for picture in dropped:
            (self._directory / picture.file).unlink(missing_ok=True)

    def to_state(self) -> list[dict[str, Any]]:
        """Return the pictures as plain JSON values."""
        return [vars(picture) for picture in self.pictures]

    @classmethod
    def from_state(cls, directory: Path, most: int, state: list[dict[str, Any]]) -> Gallery:
        """Return the gallery that `to_state` described."""
        return cls(directory, most, [Picture(**item) for item in state])


def _write(path: Path, image: NDArray[np.uint8]) -> None:
    """Write a grey or BGR image as JPEG."""
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(encode_jpeg(image, JPEG_QUALITY))
