r"""The likelihood's engine: a linear Kalman filter around the measured path that turns residuals into white numbers.

State at each event (pose frame or encoder sample), relative to the smoothed measured path: position (forward,
left) [m], heading [rad], speed errors (forward, left [m/s], turn [rad/s]), the tag's coloured error (forward, left
[m], turn [rad]), wheel angles [rad], lateness of the last command [s]. Between events the position moves by
(simulated - reference) increments ``d``, by the integrated speed errors, by heading error times distance and by
lateness times the change of speed; a measurement is ``y`` = measured - reference.

The filter is linear in (d, y), and its gains depend on the noise alone. So one covariance pass serves all
hypotheses, and residual and Jacobian columns go through the same mean pass: the exact inverse root of the
covariance of the residuals, in time O(events). Whitened innovations e / sqrt(S) are N(0, 1) for the true model.
Source: prediction-error decomposition, Schweppe, IEEE Trans. Inf. Theory 11 (1965) 61.
"""

from __future__ import annotations

import numpy as np
from numba import njit

STATES = 12
WIDTH = 12  # of a row of the covariance: whole vectors of the processor
START_POSITION, START_HEADING, START_WHEEL = 0.5, 1.0, 5.0  # m, rad, rad: nothing known at a restart
LATENESS_MEMORY = 0.5  # s: longer than robots take to follow a command
ENTRY_SPREAD = 10.0  # how much wider the speed error is at a restart while moving


@njit(cache=True, fastmath=True)
def transitions(dt, moving, surge, anew, noise, geometry):  # type: ignore[no-untyped-def]
    """Return how the state moves to each event, shape (n, 10); arguments as in `covariance_pass`.

    Columns: decay of the speed errors [1], reach [s] (what a speed error of 1 moves the robot by), fade of the tag's
    error [1], what a speed error of 1 m/s and 1 rad/s turns the wheels by [rad s/m, rad s/rad], fade of the lateness
    [1], and what a lateness of 1 s moves the robot forward by [m/s], turns it by, and turns its wheels by [rad/s].
    """
    out = np.empty((len(dt), 10))
    for k in range(len(dt)):
        decay = np.exp(-dt[k] / noise[5])
        reach = moving[k] * noise[5] * (1.0 - decay)
        out[k, 0], out[k, 1], out[k, 2] = decay, reach, noise[8] ** (dt[k] / geometry[2])
        out[k, 3], out[k, 4] = reach / geometry[1], reach * geometry[0] / geometry[1]
        ahead, twist = surge[k, 0] / geometry[1], surge[k, 1] * geometry[0] / geometry[1]
        out[k, 5] = 0.0 if anew[k] else np.exp(-dt[k] / LATENESS_MEMORY)
        out[k, 6], out[k, 7] = surge[k, 0], surge[k, 1]
        out[k, 8], out[k, 9] = ahead - twist, ahead + twist
    return out


@njit(cache=True, fastmath=True)
def covariance_pass(dt, rotation, step, moving, seen, restart, moves, noise, geometry):  # type: ignore[no-untyped-def]
    """Return the gains K (n, 5, 12) and the innovation variances S (n, 5).

    Parameters
    ----------
    dt : (n,) time since the event before [s]; rotation : (n, 2) cos and sin of the reference's turn over it.
    step : (n, >= 2) reference increment forward, left [m], in the frame at its start.
    moving : (n,) share in [0, 1] that the robot moves; seen : (n, 5) what was measured; restart : (n,) the chain
    of increments is broken here (first event, gap). moves : (n, 10) `transitions`. noise : (10,) `Noise.vector`.
    geometry : (3,) half axle length [m] and wheel radius [m] for the encoders, frame interval [s].
    """
    n = len(dt)
    gains = np.zeros((n, 5, STATES))
    variances = np.ones((n, 5))
    size = states_in_use(seen, noise[9])
    p = np.zeros((STATES, WIDTH))
    room = np.zeros((STATES, WIDTH))
    ph = np.zeros(WIDTH)
    for k in range(n):
        if restart[k]:
            restart_at(p, moving[k], noise)
        else:
            advance(p, room, dt[k], rotation[k], step[k], moving[k], moves[k], noise, geometry, size)
        for m in range(5):
            if seen[k, m]:
                variances[k, m] = measure(p, m, noise, size, ph, gains[k, m])
    return gains, variances


@njit(cache=True, fastmath=True, forceinline=True)
def advance(p, room, dt, rotation, step, moving, move, noise, geometry, size):  # type: ignore[no-untyped-def]
    """Move the covariance P (12, 12) to the next event: F P F' + Q; `room` (12, 12) to work in."""
    _move_columns(p, room, move, rotation, step, size)
    _move_columns(room, p, move, rotation, step, size)
    _add_noise(p, dt, rotation[0], rotation[1], moving, move, noise, geometry)


@njit(cache=True, fastmath=True, forceinline=True)
def measure(p, m, noise, size, ph, gain):  # type: ignore[no-untyped-def]
    """Take in coordinate m: fill its gain (12,), lower P, return the innovation's variance; `ph` (12,) to work in."""
    own = m + 6  # the tag's error of this coordinate, or the wheel
    if m < 3:
        for j in range(WIDTH):
            ph[j] = p[own, j] + p[m, j]
        s = 1e-10 + ph[m] + ph[own]
    else:
        for j in range(WIDTH):
            ph[j] = p[own, j]
        s = noise[6] ** 2 + ph[own]
    share = 1.0 / s
    for i in range(size):
        g = share * ph[i]
        gain[i] = g
        for j in range(WIDTH):
            p[i, j] -= g * ph[j]
    return s


@njit(cache=True, fastmath=True, forceinline=True)
def restart_at(p, moving, noise):  # type: ignore[no-untyped-def]
    """Fill P with what is known where the chain of increments begins: nothing."""
    p[:] = 0.0
    spread = 1.0 + (ENTRY_SPREAD - 1.0) * moving  # the speed at a restart is not known when it moves
    for i in range(3):
        p[i, i] = START_HEADING**2 if i == 2 else START_POSITION**2
        p[3 + i, 3 + i] = (spread * noise[2 + i]) ** 2
        p[6 + i, 6 + i] = noise[1] ** 2 if i == 2 else noise[0] ** 2
    p[9, 9] = p[10, 10] = START_WHEEL**2
    p[11, 11] = noise[9] ** 2


@njit(cache=True, fastmath=True, forceinline=True)
def _move_columns(p, out, move, rotation, step, size):  # type: ignore[no-untyped-def]
    """Fill `out` with (F P)': every column of P moves as `move_mean` moves a mean, and becomes a row."""
    c, s, forward, left = rotation[0], rotation[1], step[0], step[1]
    decay, reach, fade, wheel, twist = move[0], move[1], move[2], move[3], move[4]
    keep, surge, swing, left_late, right_late = move[5], move[6], move[7], move[8], move[9]
    for j in range(size):
        ahead, aside, turn, late = p[3, j], p[4, j], p[5, j], p[11, j]
        a = p[0, j] - left * p[2, j] + reach * ahead + surge * late
        b = p[1, j] + forward * p[2, j] + reach * aside
        out[j, 0], out[j, 1], out[j, 2] = c * a + s * b, c * b - s * a, p[2, j] + reach * turn + swing * late
        out[j, 3], out[j, 4], out[j, 5] = decay * ahead, decay * aside, decay * turn
        a, b = p[6, j], p[7, j]
        out[j, 6], out[j, 7], out[j, 8] = fade * (c * a + s * b), fade * (c * b - s * a), fade * p[8, j]
        out[j, 9], out[j, 10] = (
            p[9, j] + wheel * ahead - twist * turn + left_late * late,
            p[10, j] + wheel * ahead + twist * turn + right_late * late,
        )
        out[j, 11] = keep * late


@njit(cache=True, fastmath=True, forceinline=True)
def _add_noise(p, dt, c, s, moving, move, noise, geometry):  # type: ignore[no-untyped-def]
    """Add the exact covariance of Ornstein-Uhlenbeck speed errors and their integrals, tag colour and wheel slip."""
    memory = noise[5]
    ratio, decay = dt / memory, move[0]
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
    renewed = 1.0 - move[2] * move[2]
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
    p[11, 11] += (1.0 - move[5] * move[5]) * noise[9] ** 2


@njit(cache=True, fastmath=True, inline="always")
def _both(p, i, j, value):  # type: ignore[no-untyped-def]
    p[i, j] += value
    p[j, i] += value


@njit(cache=True, fastmath=True)
def mean_pass(rotation, step, seen, restart, moves, gains, scale, late, d, y, out):  # type: ignore[no-untyped-def]
    """Fill `out` (N, m) with the whitened innovations of m columns, event by event.

    d : (n, 5, m) increments simulated - reference (forward, left [m], turn, wheel left, right [rad]) over the
    interval before each event; y : (n, 5) measured - reference, used for column 0 only (the others are
    derivatives: the measurement does not depend on the parameters). scale : (n, 5) 1 / sqrt(S). late : the
    jitter of the commands [s]. What was not seen, and what only restarts the chain, has no row.
    """
    n, _, m = d.shape
    x = np.zeros((STATES, m))
    e = np.zeros(m)
    size = states_in_use(seen, late)
    row = 0
    for k in range(n):
        if restart[k]:
            x[:] = 0.0
        else:
            move_mean(x, d[k], moves[k], rotation[k], step[k], m)
            if late > 0.0:
                move_late(x, moves[k], rotation[k], m)
        for i in range(5):
            if not seen[k, i]:
                continue
            for j in range(m):
                e[j] = -x[i, j] - x[i + 6, j] if i < 3 else -x[i + 6, j]
            e[0] += y[k, i]
            if not restart[k]:
                for j in range(m):
                    out[row, j] = e[j] * scale[k, i]
                row += 1
            for q in range(size):
                g = gains[k, i, q]
                for j in range(m):
                    x[q, j] += g * e[j]


@njit(cache=True, fastmath=True, forceinline=True)
def move_late(x, move, rotation, m):  # type: ignore[no-untyped-def]
    """Advance the mean of every column by its lateness: the last state moves place, heading and wheels."""
    for j in range(m):
        late = x[11, j]
        x[0, j] += rotation[0] * move[6] * late
        x[1, j] -= rotation[1] * move[6] * late
        x[2, j] += move[7] * late
        x[9, j] += move[8] * late
        x[10, j] += move[9] * late
        x[11, j] = move[5] * late


@njit(cache=True, fastmath=True, forceinline=True)
def states_in_use(seen, late):  # type: ignore[no-untyped-def]
    """Return how many of the states anything is known of."""
    if late > 0.0:
        return STATES
    return 11 if seen[:, 3].any() else 9


@njit(cache=True, fastmath=True, forceinline=True)
def move_mean(x, d, move, rotation, step, m):  # type: ignore[no-untyped-def]
    """Advance the mean of every column: x = F x + d."""
    c, s, forward, left = rotation[0], rotation[1], step[0], step[1]
    decay, reach, fade, wheel, twist = move[0], move[1], move[2], move[3], move[4]
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
