r"""The likelihood's engine: a linear Kalman filter around the measured path that turns residuals into white numbers.

State at each event (pose frame or encoder sample), relative to the smoothed measured path: position (forward,
left) [m], heading [rad], speed errors (forward, left [m/s], turn [rad/s]), the tag's coloured error (forward, left
[m], turn [rad]), wheel angles [rad]. Between events the position moves by (simulated - reference) increments ``d``,
by the integrated speed errors and by heading error times distance; a measurement is ``y`` = measured - reference.

The filter is linear in (d, y), and its gains depend on the noise alone. So one covariance pass serves all
hypotheses, and residual and Jacobian columns go through the same mean pass: the exact inverse root of the
covariance of the residuals, in time O(events). Whitened innovations e / sqrt(S) are N(0, 1) for the true model.
Source: prediction-error decomposition, Schweppe, IEEE Trans. Inf. Theory 11 (1965) 61.
"""

from __future__ import annotations

import numpy as np
from numba import njit

STATES = 11
START_POSITION, START_HEADING, START_WHEEL = 0.5, 1.0, 5.0  # m, rad, rad: nothing known at a restart
ENTRY_SPREAD = 10.0  # how much wider the speed error is at a restart while moving


@njit(cache=True, fastmath=True)
def covariance_pass(dt, rotation, step, moving, seen, restart, noise, geometry):  # type: ignore[no-untyped-def]
    """Return the gains K (n, 5, 11) and the innovation variances S (n, 5).

    Parameters
    ----------
    dt : (n,) time since the event before [s]; rotation : (n, 2) cos and sin of the reference's turn over it.
    step : (n, 2) reference increment forward, left [m], in the frame at its start.
    moving : (n,) share in [0, 1] that the robot moves; seen : (n, 5) what was measured; restart : (n,) the chain
    of increments is broken here (first event, gap). noise : (9,) `Noise.vector`. geometry : (3,) half axle
    length [m] and wheel radius [m] for the encoders, frame interval [s].
    """
    n = len(dt)
    gains = np.zeros((n, 5, 11))
    variances = np.ones((n, 5))
    size = 11 if seen[:, 3].any() else 9
    p = np.zeros((11, 11))
    f = np.zeros((11, 11))
    fp = np.zeros((11, 11))
    h = np.zeros(11)
    ph = np.zeros(11)
    for k in range(n):
        if restart[k]:
            _start(p, moving[k], noise)
        else:
            _transition(f, dt[k], rotation[k], step[k], moving[k], noise, geometry)
            _propagate(p, f, fp, size)
            _add_noise(p, dt[k], rotation[k, 0], rotation[k, 1], moving[k], noise, geometry)
        for m in range(5):
            if not seen[k, m]:
                continue
            h[:] = 0.0
            h[m if m < 3 else m + 6] = 1.0
            s = 1e-10 if m < 3 else noise[6] ** 2
            if m < 3:
                h[m + 6] = 1.0
            for i in range(size):
                ph[i] = p[i, m] + p[i, m + 6] if m < 3 else p[i, m + 6]
            for i in range(size):
                s += h[i] * ph[i]
            variances[k, m] = s
            for i in range(size):
                gains[k, m, i] = ph[i] / s
            for i in range(size):
                for j in range(size):
                    p[i, j] -= gains[k, m, i] * ph[j]
    return gains, variances


@njit(cache=True, fastmath=True)
def _start(p, moving, noise):  # type: ignore[no-untyped-def]
    p[:] = 0.0
    spread = 1.0 + (ENTRY_SPREAD - 1.0) * moving  # the speed at a restart is not known when it moves
    for i in range(3):
        p[i, i] = START_HEADING**2 if i == 2 else START_POSITION**2
        p[3 + i, 3 + i] = (spread * noise[2 + i]) ** 2
        p[6 + i, 6 + i] = noise[1] ** 2 if i == 2 else noise[0] ** 2
    p[9, 9] = p[10, 10] = START_WHEEL**2


@njit(cache=True, fastmath=True)
def _propagate(p, f, fp, size):  # type: ignore[no-untyped-def]
    """Replace P by F P F'."""
    for i in range(size):
        for j in range(size):
            fp[i, j] = 0.0
        for m in range(size):
            a = f[i, m]
            if a != 0.0:
                for j in range(size):
                    fp[i, j] += a * p[m, j]
    for i in range(size):
        for j in range(size):
            p[i, j] = 0.0
    for j in range(size):
        for m in range(size):
            a = f[j, m]
            if a != 0.0:
                for i in range(size):
                    p[j, i] += a * fp[i, m]


@njit(cache=True, fastmath=True)
def _transition(f, dt, rotation, step, moving, noise, geometry):  # type: ignore[no-untyped-def]
    """Fill the state transition: integrate the speed errors, then turn into the frame at the end."""
    c, s, forward, left = rotation[0], rotation[1], step[0], step[1]
    decay = np.exp(-dt / noise[5])
    reach = moving * noise[5] * (1.0 - decay)
    fade = noise[8] ** (dt / geometry[2])
    f[:] = 0.0
    f[0, 0], f[0, 1], f[1, 0], f[1, 1] = c, s, -s, c
    f[0, 2], f[1, 2] = -c * left + s * forward, s * left + c * forward
    f[0, 3], f[0, 4], f[1, 3], f[1, 4] = c * reach, s * reach, -s * reach, c * reach
    f[2, 2], f[2, 5] = 1.0, reach
    f[3, 3] = f[4, 4] = f[5, 5] = decay
    f[6, 6], f[6, 7], f[7, 6], f[7, 7] = fade * c, fade * s, -fade * s, fade * c
    f[8, 8] = fade
    f[9, 9] = f[10, 10] = 1.0
    f[9, 3] = f[10, 3] = reach / geometry[1]
    f[10, 5] = reach * geometry[0] / geometry[1]
    f[9, 5] = -f[10, 5]


@njit(cache=True, fastmath=True)
def _add_noise(p, dt, c, s, moving, noise, geometry):  # type: ignore[no-untyped-def]
    """Add the exact covariance of Ornstein-Uhlenbeck speed errors and their integrals, tag colour and wheel slip."""
    memory = noise[5]
    ratio = dt / memory
    decay = np.exp(-ratio)
    fresh = 1.0 - decay * decay
    cross = moving * memory * (1.0 - decay) ** 2
    if ratio > 0.05:
        area = (moving * memory) ** 2 * (2.0 * ratio - 3.0 + 4.0 * decay - decay * decay)
    else:
        area = (moving * memory) ** 2 * ratio**3 * (2.0 / 3.0 - 0.5 * ratio)
    qf, ql, qt = noise[2] ** 2, noise[3] ** 2, noise[4] ** 2
    p[0, 0] += area * (c * c * qf + s * s * ql)
    p[1, 1] += area * (s * s * qf + c * c * ql)
    _both(p, 0, 1, area * c * s * (ql - qf))
    p[2, 2] += area * qt
    p[3, 3] += fresh * qf
    p[4, 4] += fresh * ql
    p[5, 5] += fresh * qt
    _both(p, 0, 3, cross * c * qf)
    _both(p, 0, 4, cross * s * ql)
    _both(p, 1, 3, -cross * s * qf)
    _both(p, 1, 4, cross * c * ql)
    _both(p, 2, 5, cross * qt)
    renewed = 1.0 - noise[8] ** (2.0 * dt / geometry[2])
    p[6, 6] += renewed * noise[0] ** 2
    p[7, 7] += renewed * noise[0] ** 2
    p[8, 8] += renewed * noise[1] ** 2
    b, r = geometry[0], geometry[1]
    for w in range(2):
        turn = -b if w == 0 else b
        p[9 + w, 9 + w] += area * (qf + b * b * qt) / r**2 + moving * dt * noise[7] ** 2
        _both(p, 9 + w, 0, area * c * qf / r)
        _both(p, 9 + w, 1, -area * s * qf / r)
        _both(p, 9 + w, 2, turn * area * qt / r)
        _both(p, 9 + w, 3, cross * qf / r)
        _both(p, 9 + w, 5, turn * cross * qt / r)
    _both(p, 9, 10, area * (qf - b * b * qt) / r**2)


@njit(cache=True, fastmath=True, inline="always")
def _both(p, i, j, value):  # type: ignore[no-untyped-def]
    p[i, j] += value
    p[j, i] += value


@njit(cache=True, fastmath=True)
def mean_pass(dt, rotation, step, moving, seen, restart, noise, geometry, gains, scale, d, y):  # type: ignore[no-untyped-def]
    """Return the whitened innovations, shape (n, 5, m), of m columns.

    d : (n, 5, m) increments simulated - reference (forward, left [m], turn, wheel left, right [rad]) over the
    interval before each event; y : (n, 5) measured - reference, used for column 0 only (the others are
    derivatives: the measurement does not depend on the parameters). scale : (n, 5) 1 / sqrt(S). What was not
    seen, and what only restarts the chain, is 0.
    """
    n, _, m = d.shape
    out = np.zeros((n, 5, m))
    x = np.zeros((11, m))
    e = np.zeros(m)
    size = 11 if seen[:, 3].any() else 9
    for k in range(n):
        if restart[k]:
            x[:] = 0.0
        else:
            _move(x, d[k], dt[k], rotation[k], step[k], moving[k], noise, geometry, m)
        for i in range(5):
            if not seen[k, i]:
                continue
            for j in range(m):
                e[j] = -x[i, j] - x[i + 6, j] if i < 3 else -x[i + 6, j]
            e[0] += y[k, i]
            if not restart[k]:
                for j in range(m):
                    out[k, i, j] = e[j] * scale[k, i]
            for q in range(size):
                g = gains[k, i, q]
                for j in range(m):
                    x[q, j] += g * e[j]
    return out


@njit(cache=True, fastmath=True)
def _move(x, d, dt, rotation, step, moving, noise, geometry, m):  # type: ignore[no-untyped-def]
    """Advance the mean of every column: x = F x + d."""
    c, s, forward, left = rotation[0], rotation[1], step[0], step[1]
    decay = np.exp(-dt / noise[5])
    reach = moving * noise[5] * (1.0 - decay)
    fade = noise[8] ** (dt / geometry[2])
    wheel, twist = reach / geometry[1], reach * geometry[0] / geometry[1]
    for j in range(m):
        a = x[0, j] - left * x[2, j] + reach * x[3, j] + d[0, j]
        b = x[1, j] + forward * x[2, j] + reach * x[4, j] + d[1, j]
        x[0, j] = c * a + s * b
        x[1, j] = c * b - s * a
        x[2, j] += reach * x[5, j] + d[2, j]
        x[9, j] += wheel * x[3, j] - twist * x[5, j] + d[3, j]
        x[10, j] += wheel * x[3, j] + twist * x[5, j] + d[4, j]
        x[3, j] *= decay
        x[4, j] *= decay
        x[5, j] *= decay
        a, b = x[6, j], x[7, j]
        x[6, j] = fade * (c * a + s * b)
        x[7, j] = fade * (c * b - s * a)
        x[8, j] *= fade
