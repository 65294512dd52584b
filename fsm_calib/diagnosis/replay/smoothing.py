"""The measured path, cleaned of lone spikes and smoothed, as an exogenous track.

The track only linearises the likelihood and tells place, heading and whether the robot moves; no residual is ever
formed from it, and no pose is differentiated. Smoother: Rauch, Tung & Striebel, AIAA J. 3 (1965) 1445, with a
constant-velocity model.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from fsm_calib.diagnosis.replay.heading_unwrap import FULL_TURN, SHORT_GAP
from fsm_calib.recording.chord_noise import chord_noise
from fsm_calib.types import FloatArray

SPIKE_DEVIATIONS = 6.0  # robust standard deviations from the neighbours' chord; 1e-9 for normal noise
SPIKE_LONELINESS = 0.75  # a step moves both of its frames equally (1.0), a lone spike its neighbours by half
ACCELERATION_DENSITIES = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0)  # (m/s2)^2 s; tried, the likeliest is taken
ANYWHERE = 100.0  # m2 or rad2: variance of where a path begins anew
UNKNOWN_RATE = 1e3  # s: variance of its rate there, over the acceleration density
TURN_TO_SPEED = 10.0  # 1/m: a small robot's angular accelerations over its linear ones (0.1 m axle)


@dataclass(frozen=True, eq=False)
class SmoothTrack:
    """A smoothed path: time [s], x, y [m], theta [rad, unwrapped], and rates [m/s, m/s, rad/s], all shape (n,)."""

    time: FloatArray
    x: FloatArray
    y: FloatArray
    theta: FloatArray
    vx: FloatArray
    vy: FloatArray
    omega: FloatArray

    def poses(self) -> FloatArray:
        """Return time, x, y, theta as an array of shape (n, 4)."""
        return np.column_stack([self.time, self.x, self.y, self.theta])


def lone_spikes(time: FloatArray, value: FloatArray, *, turning: bool = False) -> np.ndarray:
    """Return a mask, shape (n,), of values that leave the chord of their two neighbours, which agree.

    A step (a marker put down in the wrong place, a push) is kept: it moves two frames, not one. turning : values are
    headings [rad], of which whole turns do not count between neighbours that lie within `SHORT_GAP`: one that is half
    round and back would otherwise be half of a whole turn.
    """
    spikes = np.zeros(len(value), dtype=bool)
    if len(value) < 5:
        return spikes
    share = (time[1:-1] - time[:-2]) / (time[2:] - time[:-2])
    off, ahead, across = np.zeros(len(value)), value[1:-1] - value[:-2], value[2:] - value[:-2]
    if turning:
        quick = time[2:] - time[:-2] < SHORT_GAP
        across = np.where(quick, _nearest(across), across)
    off[1:-1] = ahead - share * across
    if turning:
        off[1:-1] = np.where(quick, _nearest(off[1:-1]), off[1:-1])
    size = np.abs(off)
    limit = SPIKE_DEVIATIONS * max(1.4826 * float(np.median(size[1:-1])), 1e-9)
    beside = np.maximum(np.roll(size, 1), np.roll(size, -1))
    spikes[1:-1] = (size > limit)[1:-1] & (beside < SPIKE_LONELINESS * size)[1:-1]
    return spikes


def _nearest(turn: FloatArray) -> FloatArray:
    """Return turns [rad] without whole turns, nearest to zero."""
    return np.asarray(turn - FULL_TURN * np.round(turn / FULL_TURN))


def smooth_track(
    time: FloatArray, x: FloatArray, y: FloatArray, theta: FloatArray, at: FloatArray, leap: np.ndarray
) -> SmoothTrack:
    """Return the likeliest constant-velocity smoothing of a measured path, given at the times `at` [s].

    time [s], x, y [m], theta [rad, unwrapped]: shape (n,); leap (n,): no robot got there from the pose before, so that
    the path begins anew. Noise is taken from the differences of neighbours and the acceleration density by maximum
    likelihood over a short list.
    """
    xs, vx, density = _smooth_best(time, x, at, leap, 1.0)
    ys, vy = _smooth(time, y, at, leap, density, chord_noise(y))
    turned, omega, _ = _smooth_best(time, theta, at, leap, TURN_TO_SPEED**2)
    return SmoothTrack(at, xs, ys, turned, vx, vy, omega)


def _smooth_best(
    time: FloatArray, value: FloatArray, at: FloatArray, leap: np.ndarray, scale: float
) -> tuple[FloatArray, FloatArray, float]:
    noise = chord_noise(value)
    scores = [_forward(time, value, leap, noise, scale * density)[0] for density in ACCELERATION_DENSITIES]
    density = scale * ACCELERATION_DENSITIES[int(np.argmax(scores))]
    smoothed, rate = _smooth(time, value, at, leap, density, noise)
    return smoothed, rate, density


def _smooth(
    time: FloatArray, value: FloatArray, at: FloatArray, leap: np.ndarray, density: float, noise: float
) -> tuple[FloatArray, FloatArray]:
    """Smooth at the union of both time sets, then pick `at`."""
    every, where = np.unique(np.concatenate([time, at]), return_inverse=True)
    seen = np.full(len(every), np.nan)
    seen[where[: len(time)]] = value
    anew = np.zeros(len(every), dtype=bool)
    anew[where[: len(time)]] = leap
    smoothed, rate = _rts(every, seen, anew, noise, density)
    chosen = where[len(time) :]
    return smoothed[chosen], rate[chosen]


@njit(cache=True)
def _forward(time, value, leap, noise, density):  # type: ignore[no-untyped-def]
    """Kalman filter of (value, rate); returns log-likelihood, filtered means and covariances (p00, p01, p11)."""
    n = len(time)
    mean, cov = np.empty((n, 2)), np.empty((n, 3))
    first = 0
    while first < n - 1 and np.isnan(value[first]):
        first += 1
    m0, m1, p00, p01, p11 = value[first], 0.0, noise**2 * 100.0, 0.0, UNKNOWN_RATE * density
    score = 0.0
    for k in range(n):
        if k > 0:
            dt = time[k] - time[k - 1]
            m0 += dt * m1
            p00 += dt * (2 * p01 + dt * p11) + density * dt**3 / 3
            p01 += dt * p11 + density * dt**2 / 2
            p11 += density * dt
            if leap[k]:
                p00 += ANYWHERE
                p11 += UNKNOWN_RATE * density
        if not np.isnan(value[k]):
            s, e = p00 + noise**2, value[k] - m0
            weight = 1.0 / (1.0 + (e * e / s) / 25.0)  # soft: a missed outlier pulls little
            r = s / weight
            score += -0.5 * (np.log(s) + 26.0 * np.log1p(e * e / s / 25.0))
            k0, k1 = p00 / r, p01 / r
            m0, m1 = m0 + k0 * e, m1 + k1 * e
            p00, p01, p11 = p00 - k0 * p00, p01 - k0 * p01, p11 - k1 * p01
        mean[k, 0], mean[k, 1] = m0, m1
        cov[k, 0], cov[k, 1], cov[k, 2] = p00, p01, p11
    return score, mean, cov


@njit(cache=True)
def _rts(time, value, leap, noise, density):  # type: ignore[no-untyped-def]
    """Backward pass of the smoother over the filtered states."""
    _, mean, cov = _forward(time, value, leap, noise, density)
    smooth = mean.copy()
    for k in range(len(time) - 2, -1, -1):
        dt = time[k + 1] - time[k]
        p00, p01, p11 = cov[k]
        q00 = p00 + dt * (2 * p01 + dt * p11) + density * dt**3 / 3
        q01 = p01 + dt * p11 + density * dt**2 / 2
        q11 = p11 + density * dt
        if leap[k + 1]:
            q00 += ANYWHERE
            q11 += UNKNOWN_RATE * density
        det = max(q00 * q11 - q01 * q01, 1e-300)
        a0, a1 = p00 + dt * p01, p01 + dt * p11  # P F' columns: (p00 + dt p01, p01), (p01 + dt p11, p11)
        d0 = smooth[k + 1, 0] - (mean[k, 0] + dt * mean[k, 1])
        d1 = smooth[k + 1, 1] - mean[k, 1]
        w0, w1 = (q11 * d0 - q01 * d1) / det, (q00 * d1 - q01 * d0) / det
        smooth[k, 0] += a0 * w0 + p01 * w1
        smooth[k, 1] += a1 * w0 + p11 * w1
    return smooth[:, 0].copy(), smooth[:, 1].copy()
