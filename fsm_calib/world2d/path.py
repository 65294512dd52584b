"""The path that stands in for the simulated pose where an effect asks for place, heading or the wheels' phase."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fsm_calib.errors import InputError
from fsm_calib.types import FloatArray
from fsm_calib.world2d.parameters import parameter_table


@dataclass(frozen=True, eq=False)
class Path:
    """A path, ready to be looked at again and again at the same sample times.

    track : shape (m, 4) or (m, 6): time [s], x, y [m], theta [rad] (not wrapped), and perhaps the wheels' angles [rad];
    without them the angles follow from the path by rolling without slip. samples : (n,) [s]. Between and beyond rows:
    linear, held.
    """

    track: FloatArray
    samples: FloatArray

    @classmethod
    def of(cls, track: FloatArray, samples: FloatArray) -> Path:
        """Return a path of rows that are checked.

        Raises
        ------
        InputError
            The track has no rows, or neither four nor six columns.
        """
        rows = np.asarray(track, dtype=float)
        if rows.ndim != 2 or rows.shape[1] not in (4, 6) or len(rows) < 1:
            raise InputError(
                f"a track of shape {rows.shape}, expected (n, 4): t, x, y, theta, or (n, 6) with wheel angles"
            )
        return cls(rows, samples)

    def at(self, parameters: FloatArray, wheels: bool) -> FloatArray:
        """Return place, heading and wheel angles at the sample times, shape (n, 5), of a robot with `parameters`.

        wheels : whether anybody asks for the angles; zeros otherwise, where nobody measured them.
        """
        if not wheels or self.track.shape[1] == 6:
            return self._seen
        angles = rolled_angles(self.track, parameters)
        return np.column_stack([self._seen[:, :3], *(self._between(column) for column in angles.T)])

    @cached_property
    def _seen(self) -> FloatArray:
        out = np.zeros((len(self.samples), 5))
        for i, column in enumerate(self.track.T[1:]):
            out[:, i] = self._between(column)
        return out

    def _between(self, column: FloatArray) -> FloatArray:
        return np.interp(self.samples, self.track[:, 0], column)


def rolled_angles(track: FloatArray, parameters: FloatArray) -> FloatArray:
    """Return the wheels' angles [rad], shape (m, 2), of a path (t, x, y, theta) rolled without slip from zero."""
    table = parameter_table()
    axle, left, right = (
        parameters[table.index[n]] for n in ("axle_length", "wheel_radius_left", "wheel_radius_right")
    )
    dx, dy, turn = np.diff(track[:, 1]), np.diff(track[:, 2]), np.diff(track[:, 3])
    heading = 0.5 * (track[1:, 3] + track[:-1, 3])
    ahead = (dx * np.cos(heading) + dy * np.sin(heading)) / np.sinc(turn / (2.0 * np.pi))
    steps = np.column_stack([(ahead - 0.5 * axle * turn) / left, (ahead + 0.5 * axle * turn) / right])
    return np.vstack([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
