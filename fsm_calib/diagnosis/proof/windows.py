"""Errors over a horizon: predict some seconds from a filtered start, compare with what was measured, and the floor.

Every whole second of a recording starts a window: the pose, and the momentary speed error, are those of the
likelihood's filter; then the model runs `horizon` seconds on commands alone. The error is measured - predicted pose
at the end. The floor is the median that the same prediction would have if the estimated noise were all that is
wrong: from the filter's own covariance, start and measurement included.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

from fsm_calib.diagnosis.likelihood.noise import Noise
from fsm_calib.diagnosis.likelihood.whitening import (
    STATES,
    WIDTH,
    advance,
    measure,
    move_late,
    move_mean,
    restart_at,
    states_in_use,
    transitions,
)
from fsm_calib.diagnosis.replay.prepared import Prepared
from fsm_calib.types import FloatArray

WINDOW_STEP = 0.25  # s between starts of windows; overlapping windows steady the median
LENGTH_SLACK = 0.15  # s by which a window may be too short or long (slow trackers: one frame)
NORMAL_MEDIAN = 0.67449  # median of |N(0, 1)|


@dataclass(frozen=True, slots=True)
class HorizonError:
    """Median errors over all windows: position [m], heading [rad]; nan when there was no whole window."""

    xy_m: float
    theta_rad: float


@dataclass(frozen=True, eq=False)
class Windows:
    """Windows of one recording: end times (w,) [s], errors (w, 3) ahead, left [m], turn [rad], floors (w, 2)."""

    time: FloatArray
    error: FloatArray
    floor: FloatArray


def prediction_windows(
    prepared: Prepared,
    noise: Noise,
    simulated: FloatArray,
    places: tuple[np.ndarray, np.ndarray] | None = None,
) -> Windows:
    """Return the errors of predictions over the settings' horizon, or between the events (starts, ends) given."""
    starts, ends = window_places(prepared) if places is None else places
    p = prepared
    error, spread = _predict(
        p.dt, p.rotation, p.step, p.moving, p.surge, p.anew, p.seen, p.restart, noise.vector(), p.geometry,
        np.ascontiguousarray(simulated - p.step)[:, :, None], p.y, starts, ends,
    )  # fmt: skip
    floor = np.column_stack(
        [_median_radius(spread[:, 0], spread[:, 1]), NORMAL_MEDIAN * np.sqrt(spread[:, 2])]
    )
    if not p.poses.placed:
        error[:, :2], floor[:, 0] = np.nan, np.nan
    return Windows(p.time[ends], error, floor)


def window_places(prepared: Prepared) -> tuple[np.ndarray, np.ndarray]:
    """Return the events (starts, ends) of windows that hold no gap and end at a measured pose."""
    time, horizon = prepared.time, prepared.settings.horizon
    poses = np.flatnonzero(prepared.seen[:, 2])
    wanted = np.arange(time[0] + 0.5, time[-1] - horizon, WINDOW_STEP)
    starts = poses[np.minimum(np.searchsorted(time[poses], wanted), len(poses) - 1)]
    ends = poses[np.minimum(np.searchsorted(time[poses], time[starts] + horizon), len(poses) - 1)]
    breaks = np.cumsum(prepared.restart)
    whole = (
        (breaks[starts] == breaks[ends])
        & (np.abs(time[ends] - time[starts] - horizon) < max(LENGTH_SLACK, prepared.geometry[2]))
        & (starts < ends)
    )
    pairs = np.unique(np.column_stack([starts, ends])[whole], axis=0)
    return pairs[:, 0], pairs[:, 1]


def median_error(windows: Sequence[Windows]) -> HorizonError:
    """Return the medians over all windows of all recordings."""
    error = np.vstack([w.error for w in windows])
    if not len(error):
        return HorizonError(float("nan"), float("nan"))
    return HorizonError(
        float(np.median(np.hypot(error[:, 0], error[:, 1]))), float(np.median(np.abs(error[:, 2])))
    )


def median_floor(windows: Sequence[Windows]) -> HorizonError:
    """Return the medians that the noise alone would give."""
    floor = np.vstack([w.floor for w in windows])
    if not len(floor):
        return HorizonError(float("nan"), float("nan"))
    return HorizonError(float(np.median(floor[:, 0])), float(np.median(floor[:, 1])))


def _median_radius(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the median of sqrt(x^2 + y^2) for independent normal x, y of variances a, b.

    Wilson-Hilferty for the weighted sum of squares: exact to 1 % (compare Rayleigh: sqrt(2 ln 2) sd).
    """
    mean, variance = a + b, 2.0 * (a * a + b * b)
    freedom = 2.0 * mean**2 / np.maximum(variance, 1e-300)
    return np.sqrt(mean * (1.0 - 2.0 / (9.0 * freedom)) ** 3)


@njit(cache=True)
def _predict(dt, rotation, step, moving, surge, anew, seen, restart, noise, geometry, d, y, starts, ends):  # type: ignore[no-untyped-def]
    """Filter up to each start, then run on without measurements; return errors (w, 3) and their variances (w, 3)."""
    n = len(dt)
    size = states_in_use(seen, noise[9])
    moves = transitions(dt, moving, surge, anew, noise, geometry)
    x, run = np.zeros((STATES, 1)), np.zeros((STATES, 1))
    p, q, room = np.zeros((STATES, WIDTH)), np.zeros((STATES, WIDTH)), np.zeros((STATES, WIDTH))
    ph, gain = np.zeros(WIDTH), np.zeros(STATES)
    error, spread = np.zeros((len(starts), 3)), np.zeros((len(starts), 3))
    w = 0
    for k in range(n):
        if restart[k]:
            x[:] = 0.0
            restart_at(p, moving[k], noise)
        else:
            move_mean(x, d[k], moves[k], rotation[k], step[k], 1)
            move_late(x, moves[k], rotation[k], 1)
            advance(p, room, dt[k], rotation[k], step[k], moving[k], moves[k], noise, geometry, size)
        for m in range(5):
            if not seen[k, m]:
                continue
            e = y[k, m] - x[m + 6, 0] - (x[m, 0] if m < 3 else 0.0)
            measure(p, m, noise, size, ph, gain)
            for i in range(size):
                x[i, 0] += gain[i] * e
        while w < len(starts) and starts[w] == k:
            run[:] = x
            q[:] = p
            for i in range(k + 1, ends[w] + 1):
                move_mean(run, d[i], moves[i], rotation[i], step[i], 1)
                move_late(run, moves[i], rotation[i], 1)
                advance(q, room, dt[i], rotation[i], step[i], moving[i], moves[i], noise, geometry, size)
            for m in range(3):
                error[w, m] = y[ends[w], m] - run[m, 0] - run[m + 6, 0]
                spread[w, m] = q[m, m] + 2.0 * q[m, m + 6] + q[m + 6, m + 6]
            w += 1
    return error, spread
