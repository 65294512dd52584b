"""When was it pushed? Kicks at every moment, each judged on the seconds after it.

A kick is a speed error that fades as the motors bring the robot back; while somebody leans on the robot, the error
stays. Its poses are outliers to a robust likelihood whose noise the push itself has widened: a score test, which sees
no more of an outlier than its weight, promised a push of 1.3 N nothing. So each push is fitted by reweighted least
squares (as the likelihood is, `likelihood.py`) and its gain counted in densities. The base robot is not re-fitted
beside it: it does not move for one second of a drive. How hard it was pushed is asked of a simulation (`pushed.py`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numba import njit

from fsm_calib.diagnosis.likelihood.robust import SWEEPS, log_kernel
from fsm_calib.diagnosis.replay.situation import Situation
from fsm_calib.diagnosis.shapes.features import body_columns
from fsm_calib.diagnosis.shapes.score_tests import Residual
from fsm_calib.types import FloatArray

STEP = 0.25  # s between candidate pushes
KICK = 0.25  # s that a kick lasts
HELD = (0.7, 1.5, 3.0)  # s for which somebody may lean on it: a fit finds the length from a factor of 1.5 off
APART = 0.75  # s between the end of a push and the begin of one that is not the same
FADE = 0.1  # s, of the speed error afterwards: a motor's time constant
SEEN = 2.75  # s after its end in which a push shows
GAP = 1.0  # s between what is seen of two pushes that share a column


@dataclass(frozen=True, eq=False)
class Pushes:
    """Pushes of one length [s] in one recording: starts (m,) [s], log-likelihood won (m,).

    numbers : (m, 3) the speed errors ahead, to the left and at the rim that win it [m/s]; power : (m, 3, 3) of their
    columns, weighed, so that half of numbers' power numbers is about what is won.
    """

    run: int
    length: float
    starts: FloatArray
    won: FloatArray
    numbers: FloatArray
    power: FloatArray


def are_apart(starts: FloatArray, length: FloatArray | float, start: float, lasted: float) -> np.ndarray:
    """Return which pushes of `length` [s] end well before, or begin well after, one that `lasted` [s] from `start`."""
    return np.asarray((starts + length < start - APART) | (starts > start + lasted + APART))


def apart_from(
    starts: FloatArray, length: FloatArray | float, known: Iterable[tuple[float, float]]
) -> np.ndarray:
    """Return which pushes of `length` [s] are apart from all that are known by begin and length [s]."""
    free = np.ones(len(starts), dtype=bool)
    for start, lasted in known:
        free &= are_apart(starts, length, start, lasted)
    return free


def turns(heading: FloatArray) -> FloatArray:
    """Return the rotations (m, 3, 3) by headings (m,) [rad] of what is ahead, to the left and about the vertical."""
    rotations = np.tile(np.eye(3), (len(heading), 1, 1))
    rotations[:, 0, 0] = rotations[:, 1, 1] = np.cos(heading)
    rotations[:, 1, 0] = np.sin(heading)
    rotations[:, 0, 1] = -rotations[:, 1, 0]
    return rotations


def innovations_of(residual: Residual, run: int) -> tuple[FloatArray, int]:
    """Return the times (n,) [s] of one recording's innovations, and how many stand before them."""
    prepared = residual.whiteners[run].prepared
    time = np.broadcast_to(prepared.time[:, None], prepared.scored.shape)[prepared.scored]
    return time, residual.rows(run).start


def pushes(residual: Residual, run: int, s: Situation, length: float) -> Pushes:
    """Return what a push of `length` [s] wins at each moment of one recording."""
    starts = np.arange(max(s.time[0], 0.0) + 0.5, s.time[-1] - 1.0, STEP)
    period = int(np.ceil((length + SEEN + GAP) / STEP))
    whitener, nu = residual.whiteners[run], residual.engine.nu
    time, before = innovations_of(residual, run)
    white = residual.white[before : before + len(time)]
    columns = np.empty((len(time), 3 * period))
    for channel, increments in enumerate(_trains(s, starts, length, period)):
        columns[:, channel::3] = residual.engine.white_columns((whitener,), (increments,))
    won, numbers, power = np.zeros(len(starts)), np.zeros((len(starts), 3)), np.zeros((len(starts), 3, 3))
    for b, start in enumerate(starts.tolist()):
        rows = slice(*np.searchsorted(time, (start, start + length + SEEN)))
        train = 3 * (b % period)
        won[b], numbers[b], power[b] = fitted(columns[rows, train : train + 3], white[rows], nu)
    return Pushes(run, length, starts, won, numbers, power)


def fitted(x: FloatArray, white: FloatArray, nu: float) -> tuple[float, FloatArray, FloatArray]:
    """Return the gain in log-likelihood, the numbers (3,) of columns `x` (n, 3) and the columns' weighed power (3, 3).

    By reweighted least squares.
    """
    if not len(x):
        return 0.0, np.zeros(3), np.zeros((3, 3))
    numbers, lower = _reweighted(np.ascontiguousarray(x), white, nu)
    power = lower + np.tril(lower, -1).T
    return float(log_kernel(white - x @ numbers, nu) - log_kernel(white, nu)), numbers, power


@njit(cache=True)
def _reweighted(x, white, nu):  # type: ignore[no-untyped-def]
    """Return the numbers (3,) that leave least of `white` (n,), and the lower half of the power they stand on (3, 3).

    By `robust_weights` of what the sweep before leaves.

    There are thousands of fits of a few dozen rows: by arrays, most of their time is spent in calls.
    """
    normal, moment, numbers = np.zeros((3, 3)), np.zeros(3), np.zeros(3)
    ridge = 1e-9 * np.sum(x * x) + 1e-12
    for sweep in range(SWEEPS):
        normal[:] = ridge * np.eye(3)
        moment[:] = 0.0
        for k in range(len(x)):
            left = white[k] - x[k, 0] * numbers[0] - x[k, 1] * numbers[1] - x[k, 2] * numbers[2]
            weight = (nu + 1.0) / (nu - 2.0 + left * left) if sweep else 1.0
            for i in range(3):
                moment[i] += weight * x[k, i] * white[k]
                for j in range(i + 1):
                    normal[i, j] += weight * x[k, i] * x[k, j]
        numbers = _solved(normal, moment)
    return numbers, normal


@njit(cache=True)
def _solved(lower, moment):  # type: ignore[no-untyped-def]
    """Return N^-1 m of a positive definite N (3, 3) whose lower half is given (Cholesky)."""
    root, out = np.zeros((3, 3)), np.zeros(3)
    for i in range(3):
        for j in range(i + 1):
            rest = lower[i, j]
            for k in range(j):
                rest -= root[i, k] * root[j, k]
            root[i, j] = np.sqrt(max(rest, 1e-300)) if i == j else rest / root[j, j]
    for i in range(3):
        out[i] = (moment[i] - np.sum(root[i, :i] * out[:i])) / root[i, i]
    for i in range(2, -1, -1):
        out[i] = (out[i] - np.sum(root[i + 1 :, i] * out[i + 1 :])) / root[i, i]
    return out


def _trains(s: Situation, starts: FloatArray, length: float, period: int) -> Iterator[FloatArray]:
    """Yield increments (n, 5, period) of errors of 1 m/s forward, sideways, at the rim, pushes apart added."""
    trains = np.column_stack([_train(s, starts[first::period], length) for first in range(period)])
    yield body_columns(s, forward=trains)
    yield body_columns(s, lateral=trains)
    yield body_columns(s, turn=trains / s.half)


def _train(s: Situation, starts: FloatArray, length: float) -> FloatArray:
    """Return the sum (n,) of what pushes that begin at `starts` [s] leave of their speed at each time."""
    since = s.time[:, None] - starts
    shape = np.clip(since / KICK, 0.0, 1.0) * np.exp(-np.maximum(since - length, 0.0) / FADE)
    return np.asarray(shape.sum(axis=1))
