"""Where a robot that finds itself by its own camera sees enough of the floor's tags; a bound of planned drives."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fsm_calib.types import FloatArray

CELL, SECTORS = 0.04, 36  # m and headings in a turn, of the table of what is seen from where


@dataclass(frozen=True, eq=False)
class Sight:
    """Which tags are seen from which pose.

    tags : (n, 2) places [m]. view : (r, c) bool, whether a tag at the cell of a grid in `base` is seen whole; the
    grid begins at `view_corner` (x, y) [m], x along its rows, cells of `view_cell` [m]. bounds : x_low, x_high,
    y_low, y_high of the poses that are asked for [m]. fewest : tags that a pose needs. blind : longest time without
    [s]; step : between the poses of a path [s].
    """

    tags: FloatArray
    view: np.ndarray
    view_corner: tuple[float, float]
    view_cell: float
    bounds: tuple[float, float, float, float]
    fewest: int = 2
    blind: float = 0.4
    step: float = 0.05

    @cached_property
    def _table(self) -> np.ndarray:
        """Return whether enough is seen, by cells of x, y and sectors of heading."""
        x_low, x_high, y_low, y_high = self.bounds
        xs = np.arange(x_low, x_high + CELL, CELL)
        ys = np.arange(y_low, y_high + CELL, CELL)
        headings = np.arange(SECTORS) * (2.0 * np.pi / SECTORS)
        x, y, heading = (a.ravel() for a in np.meshgrid(xs, ys, headings, indexing="ij"))
        return (self.count(x, y, heading) >= self.fewest).reshape(len(xs), len(ys), SECTORS)

    def count(self, x: FloatArray, y: FloatArray, heading: FloatArray) -> np.ndarray:
        """Return how many tags are seen from poses (n,), x, y [m], heading [rad]."""
        c, s = np.cos(heading)[:, None], np.sin(heading)[:, None]
        dx, dy = self.tags[:, 0] - np.asarray(x)[:, None], self.tags[:, 1] - np.asarray(y)[:, None]
        row = np.floor((c * dx + s * dy - self.view_corner[0]) / self.view_cell).astype(int)
        column = np.floor((c * dy - s * dx - self.view_corner[1]) / self.view_cell).astype(int)
        inside = (row >= 0) & (row < self.view.shape[0]) & (column >= 0) & (column < self.view.shape[1])
        seen = inside & self.view[np.where(inside, row, 0), np.where(inside, column, 0)]
        return np.asarray(seen.sum(axis=1))

    def enough(self, paths: FloatArray) -> np.ndarray:
        """Return for each pose of `paths` (k, n, 3) whether enough is seen, shape (k, n)."""
        table = self._table
        i = np.clip(np.rint((paths[..., 0] - self.bounds[0]) / CELL).astype(int), 0, table.shape[0] - 1)
        j = np.clip(np.rint((paths[..., 1] - self.bounds[2]) / CELL).astype(int), 0, table.shape[1] - 1)
        sector = np.rint(paths[..., 2] * (SECTORS / (2.0 * np.pi))).astype(int) % SECTORS
        return np.asarray(table[i, j, sector])

    def keeps(self, paths: FloatArray) -> bool:
        """Return whether no path (k, n, 3) is blind for longer than `blind`, or ends blind."""
        seen = self.enough(paths)
        if not seen[:, -1].all():
            return False
        window = int(self.blind / self.step) + 1
        if seen.shape[1] <= window:
            return True
        some = np.cumsum(np.pad(seen, ((0, 0), (1, 0))), axis=1)
        return bool(np.all(some[:, window:] > some[:, :-window]))
