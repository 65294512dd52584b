"""Columns of a study's rows: one number per robot, nan where a robot has none."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fsm_calib.study.variants import BASE
from fsm_calib.types import FloatArray

Row = Mapping[str, Any]
CENTIMETRE = 0.01
"""To this the paper rounds a deviation that was measured with a ruler [m] (section 4.2)."""

DEVIATION = {
    "by_hand": ("by_hand", "wheels", "deviation_2m_m"),
    "test_1": ("test_1", "wheels", "deviation_2m_m"),
    "test_2": ("test_2", "wheels", "deviation_2m_m"),
}
"""Where the deviation after 2 m of each way of calibrating stands in a row."""
CAMERA = {
    "by_hand": ("by_hand", "camera"),
    "by_hand_same_solver": ("by_hand", "camera", "same_solver"),
    "automatic": ("test_2", "camera"),
}
"""Where each camera calibration stands in a row."""


@dataclass(frozen=True, eq=False)
class Rows:
    """The rows of one variant, in the order of the robots' numbers."""

    rows: tuple[Row, ...]

    def value(self, *path: str) -> FloatArray:
        """Return the number at a path of names in each row, shape (n,); nan where there is none."""
        return np.array([_number(row, path) for row in self.rows], dtype=float)

    def text(self, *path: str) -> list[str]:
        """Return the text at a path of names in each row; empty where there is none."""
        return [str(_at(row, path) or "") for row in self.rows]

    def robots(self) -> list[int]:
        """Return the robots' numbers."""
        return [int(row["robot"]) for row in self.rows]

    def deviation(self, way: str) -> FloatArray:
        """Return the deviation after 2 m of one way [m], right positive; nan for robots that did not finish."""
        values = self.value(*DEVIATION[way])
        if way != "by_hand":
            values[[outcome != "done" for outcome in self.text(way, "outcome")]] = math.nan
        return values

    def camera(self, way: str, figure: str) -> FloatArray:
        """Return a figure of one camera calibration [px]."""
        return self.value(*CAMERA[way], figure)

    def has(self, part: str) -> bool:
        """Tell whether any robot went through a part."""
        return any(part in row for row in self.rows)


def rows_of(rows: Iterable[Row], variant: str = BASE) -> Rows:
    """Return the rows of a variant."""
    return Rows(tuple(sorted((r for r in rows if r["variant"] == variant), key=lambda r: int(r["robot"]))))


def rounded(deviation: FloatArray) -> FloatArray:
    """Return deviations as the paper measured them, to the centimetre [m]."""
    return np.round(deviation / CENTIMETRE) * CENTIMETRE


def _at(row: Any, path: Sequence[str]) -> Any:
    for name in path:
        if not isinstance(row, Mapping):
            return None
        row = row.get(name)
    return row


def _number(row: Row, path: Sequence[str]) -> float:
    value = _at(row, path)
    return math.nan if value is None else float(value)
