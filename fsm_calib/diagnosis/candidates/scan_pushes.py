"""When was it pushed? Kicks at every moment, each judged on the seconds after it.

A kick is a speed error that fades as the motors bring the robot back. Its poses are outliers to a robust likelihood
whose noise the kick itself has widened: a score test, which sees no more of an outlier than its weight, promised a
push of 1.3 N nothing. So each kick is fitted by reweighted least squares (as the likelihood is, `likelihood.py`) and
its gain counted in densities. The base robot is not re-fitted beside it: it does not move for one second of a drive.
"""

from __future__ import annotations

import numpy as np

from fsm_calib.diagnosis.likelihood.robust import log_kernel, robust_weights
from fsm_calib.diagnosis.replay.situation import Situation
from fsm_calib.diagnosis.shapes.features import body_columns
from fsm_calib.diagnosis.shapes.score_tests import Residual
from fsm_calib.types import FloatArray

STEP = 0.25  # s between candidate kicks
LENGTH = 0.25  # s
APART = 1.0  # s between kicks that are not the same one: four times its length
FADE = 0.1  # s, of the speed error afterwards: a motor's time constant
SEEN = 3.0  # s after a kick in which it shows
PERIOD = 16  # kicks of one column lie so many steps apart, a second more than each is seen
SWEEPS = 3  # of reweighted least squares
MASS, INERTIA = 1.1, 0.0065  # kg, kg m2 of a plain robot: a push's first guess


def kicks(residual: Residual, run: int, s: Situation) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return moments (m,) [s] of one recording, what kicks win there (m,), and their amplitudes (m, 3) [m/s]."""
    starts = np.arange(max(s.time[0], 0.0) + 0.5, s.time[-1] - 1.0, STEP)
    whitener, nu = residual.whiteners[run], residual.engine.nu
    scored = whitener.prepared.scored
    time = np.broadcast_to(whitener.prepared.time[:, None], scored.shape)[scored]
    before = sum(int(w.prepared.scored.sum()) for w in residual.whiteners[:run])
    white = residual.white[before : before + len(time)]
    columns = residual.engine.white_columns((whitener,), (_trains(s, starts),))
    won = np.zeros(len(starts))
    amplitude = np.zeros((len(starts), 3))
    for b, start in enumerate(starts.tolist()):
        rows = slice(*np.searchsorted(time, (start, start + SEEN)))
        train = 3 * (b % PERIOD)
        won[b], amplitude[b] = _fitted(columns[rows, train : train + 3], white[rows], nu)
    return starts, won, amplitude


def _fitted(x: FloatArray, white: FloatArray, nu: float) -> tuple[float, FloatArray]:
    """Return the gain in log-likelihood and the numbers (3,) of columns `x` (n, 3) by reweighted least squares."""
    if not len(x):
        return 0.0, np.zeros(3)
    ridge = 1e-9 * float(np.sum(x * x)) + 1e-12
    numbers: FloatArray = np.zeros(3)
    left: FloatArray = white
    weights = np.ones(len(x))
    for _ in range(SWEEPS):
        weighted = x * weights[:, None]
        normal = weighted.T @ x + ridge * np.eye(3)
        numbers = np.asarray(np.linalg.solve(normal, weighted.T @ white), dtype=float)
        left = white - x @ numbers
        weights = robust_weights(left, nu)
    return float(log_kernel(left, nu) - log_kernel(white, nu)), numbers


def _trains(s: Situation, starts: FloatArray) -> FloatArray:
    """Return increments (n, 5, 3 PERIOD): errors of 1 m/s forward, sideways, at the rim, kicks that lie apart added."""
    since = s.time[:, None] - starts
    shape = np.clip(since / LENGTH, 0.0, 1.0) * np.exp(-np.maximum(since - LENGTH, 0.0) / FADE)
    trains = np.column_stack([shape[:, first::PERIOD].sum(axis=1) for first in range(PERIOD)])
    out = np.zeros((len(s.dt), 5, 3 * PERIOD))
    out[:, :, 0::3] = body_columns(s, forward=trains)
    out[:, :, 1::3] = body_columns(s, lateral=trains)
    out[:, :, 2::3] = body_columns(s, turn=trains / s.half)
    return out


def push_of(s: Situation, start: float, amplitude: FloatArray, name: str) -> dict[str, float]:
    """Return the push, of the effect `name`, that brings about speed errors forward, sideways and at the rim [m/s]."""
    heading = float(np.interp(start, s.time, s.heading))
    ahead, left, turn = amplitude * [MASS, MASS, INERTIA / s.half]
    c, d = np.cos(heading), np.sin(heading)
    return {
        f"{name}.impulse_x": float(np.clip(c * ahead - d * left, -3, 3)),
        f"{name}.impulse_y": float(np.clip(d * ahead + c * left, -3, 3)),
        f"{name}.impulse_turn": float(np.clip(turn, -0.3, 0.3)),
        f"{name}.start": start,
    }
