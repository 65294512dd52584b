"""What a place on the floor changes, simulated only while the robot is near it.

An effect of a place acts while the exogenous track crosses it, and what it leaves fades within the robot's own lags. So
a candidate is rolled out from a little before each crossing, beginning with the twist that the parent model has there,
until a little after it; elsewhere it changes nothing. Parent and candidates begin alike, so that what the short run-up
does not know (a battery's state, a gear's play) cancels in their difference.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fsm_calib.diagnosis.replay.simulator import GRID_STEP, Simulator
from fsm_calib.types import FloatArray
from fsm_calib.world2d.path import rolled_angles
from fsm_calib.world2d.rollout import Drive

RUN_UP = 0.3  # s before a crossing: two lags of a small robot's wheels
FADE = 0.6  # s after it
JOINED = 0.8  # s: crossings that follow each other so soon are one
MEMORY = 3.0  # s of commands before the run-up: the longest delay that is looked for


@dataclass(frozen=True, eq=False)
class Passages:
    """One recording, ready to be rolled out near places.

    values : (p,) of the parent model; twist : (n, 3) its speeds [m/s, m/s, rad/s] at each event; track : the exogenous
    path with wheel angles.
    """

    simulator: Simulator
    values: FloatArray
    twist: FloatArray
    track: FloatArray

    @classmethod
    def of(cls, simulator: Simulator, values: FloatArray, simulated: FloatArray) -> Passages:
        """Prepare a recording from the parent's parameters (p,) and simulated increments (n, 5)."""
        dt = np.maximum(simulator.prepared.dt, GRID_STEP)[:, None]
        track = simulator.track
        if track.shape[1] == 4:
            track = np.column_stack([track, rolled_angles(track, values)])
        return cls(simulator, values, simulated[:, :3] / dt, track)

    def inside(self, x: float, y: float, reach: float) -> NDArray[np.int64]:
        """Return the events (k,) within `reach` [m] of a point [m]."""
        reference = self.simulator.prepared.reference
        return np.flatnonzero(np.hypot(reference[:, 0] - x, reference[:, 1] - y) < reach)

    def near(self, x: float, y: float, reach: float) -> list[tuple[int, int]]:
        """Return first and last event of every passage within `reach` [m] of a point [m]."""
        p, inside = self.simulator.prepared, self.inside(x, y, reach)
        if not len(inside):
            return []
        time = p.time[inside]
        cut = np.flatnonzero(np.diff(time) > JOINED)
        first, last = time[np.r_[0, cut + 1]], time[np.r_[cut, len(time) - 1]]
        begin = np.searchsorted(p.time, first - GRID_STEP) - 1
        end = np.searchsorted(p.time, last + FADE)
        return [(max(int(b), 0), min(int(e), len(p.time) - 1)) for b, e in zip(begin, end, strict=True)]

    def changes(self, rows: FloatArray, spans: Sequence[tuple[int, int]]) -> FloatArray:
        """Return what each of `rows` (m, p) changes in the parent's increments, (n, 5, m); zero between the spans."""
        p = self.simulator.prepared
        out = np.zeros((len(p.time), 5, len(rows)))
        both = np.vstack([self.values, rows])
        for first, last in spans:
            states = self._rolled(both, first, last)
            found = states[1:] - states[:1]
            out[first + 1 : last + 1] = np.moveaxis(found[:, 1:], 0, 2)
        return out

    def _rolled(self, rows: FloatArray, first: int, last: int) -> FloatArray:
        """Return increments (m, last - first + 1, 5) of the events of a span."""
        s, p = self.simulator, self.simulator.prepared
        begin = float(p.time[first]) - RUN_UP
        grid = np.arange(begin, float(p.time[last]) + 2 * GRID_STEP, GRID_STEP)
        start = np.r_[p.reference[first], self.twist[max(first, 1)]]
        return s.increments_between(
            rows, first, last, grid, start, self._commands(begin, grid[-1]), self.track
        )

    def _commands(self, begin: float, end: float) -> Drive:
        """Return the commands that act between two times [s]."""
        d = self.simulator.drive
        a = max(int(np.searchsorted(d.time, begin - MEMORY)) - 1, 0)
        b = int(np.searchsorted(d.time, end)) + 1
        return Drive(d.time[a:b], d.left[a:b], d.right[a:b])


def passages_of(
    simulators: Sequence[Simulator], values: FloatArray, simulated: Sequence[FloatArray]
) -> list[Passages]:
    """Return the passages of all recordings, each with its own row of `values` (R, p)."""
    return [Passages.of(s, v, i) for s, v, i in zip(simulators, values, simulated, strict=True)]
