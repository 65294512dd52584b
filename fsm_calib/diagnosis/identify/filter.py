"""A Kalman filter of the base robot: innovations of pose measurements, for maximum likelihood.

State s = (x, y, theta, v, w, bx, by): pose and speeds of the base, slowly changing error of the tracker.
Between events of `steps`, with duration h:

    driven by commands:   v(t) = V + (v0 - V) exp(-t / tau_f),   w(t) = W + (w0 - W) exp(-t / tau_t)
    driven by wheels:     path d and turn dtheta of the interval were measured

V, W [m/s, rad/s]: what the command asks for. The pose moves on the arc of the interval and, where speed and
turn rate change in it, to the left by its sway

    (dtheta dv - d dw) h / 12        dv, dw [m/s, rad/s]: gained over the interval

(second order of int v(t) sin(theta(t) - theta(h/2)) dt for v, w linear in t; without it, paths of changing
curvature come out too long, and lengths fitted to them too short). Noise of commands:
white accelerations of spectral density q_f [m2/s3] and q_t [rad2/s3]; of wheels: variances q_f |p| [m2] of
the path and q_t |p| [rad2] of the turn, p [m] = the mean way of the two wheels, forth or back (Chong, Kleeman
1997, DOI 10.1109/ROBOT.1997.606708). While nobody knows the command, the accelerations are those that lose the speeds
within UNKNOWN_AFTER; more would lose the heading, too, and no filter of this kind finds its way from there. Measured is
the tracked point's pose,

    x + R(theta) (px, py), theta + psi       with noise variances r_xy [m2], r_theta [rad2], white,

plus (bx, by) [m], which forgets itself over BIAS_LENGTH of travel and has the standard deviation s_b [m] (a
tracker's lens or map errors belong to a place); and, since a stamp may be off by a random time of variance
r_time [s2], r_time g g' with the point's velocity g.

Source: extended Kalman filter and its innovations' likelihood as in Kristensen, Madsen, Jorgensen 2004
(DOI 10.1016/j.automatica.2003.10.001), sec. 2.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

BY_WHEELS, BY_COMMANDS = 0, 1
STATES = 7
STEP_COLUMNS = 6
BIAS_LENGTH = 0.5  # m: errors of a tracker (lens, map) change over about a robot's length or a tile
DIFFUSE_POSITION = 1e2  # m2: nothing is known of the first position
DIFFUSE_ANGLE = 1e1  # rad2
FIRST_SPEED, FIRST_TURN_RATE = 0.5, 5.0  # m/s, rad/s: a recording may begin while the robot drives
STILL_SPEED, STILL_TURN_RATE = 0.005, 0.05  # m/s, rad/s: slower without a command, the robot stands
STILL_NOISE = 1e-4  # factor on the noise while it stands
SHORT = 1e-3  # of a time constant: shorter steps take the noise's integrals by their series
UNKNOWN_AFTER = 0.1  # s without a known command, until the speeds are as little known as in the beginning


@njit(cache=True, error_model="numpy")
def _chord(d, turn):  # type: ignore[no-untyped-def]
    """Return the chord [m] of an arc of length d [m] and turn [rad]."""
    half = turn / 2.0
    return d if abs(half) < 1e-9 else d * math.sin(half) / half


@njit(cache=True, error_model="numpy")
def sway(d, turn, more_d, more_turn):  # type: ignore[no-untyped-def]
    """Return how far left [m] of the arc's chord an interval ends: d [m], turn [rad]; more_d [m], more_turn
    [rad]: the speeds gained over the interval times its duration.
    """
    return (turn * more_d - d * more_turn) / 12.0


@njit(cache=True, error_model="numpy")
def _carry(P, x_theta, y_theta, x_v, y_v, x_w, y_w, theta_w, keep_v, keep_w):  # type: ignore[no-untyped-def]
    """P becomes F P F' for the F whose entries beside the unit diagonal are given."""
    for j in range(STATES):
        P[0, j] += x_theta * P[2, j] + x_v * P[3, j] + x_w * P[4, j]
        P[1, j] += y_theta * P[2, j] + y_v * P[3, j] + y_w * P[4, j]
        P[2, j] += theta_w * P[4, j]
        P[3, j] *= keep_v
        P[4, j] *= keep_w
    for i in range(STATES):
        P[i, 0] += x_theta * P[i, 2] + x_v * P[i, 3] + x_w * P[i, 4]
        P[i, 1] += y_theta * P[i, 2] + y_v * P[i, 3] + y_w * P[i, 4]
        P[i, 2] += theta_w * P[i, 4]
        P[i, 3] *= keep_v
        P[i, 4] *= keep_w


@njit(cache=True, error_model="numpy")
def _add_pair(P, i, j, value):  # type: ignore[no-untyped-def]
    P[i, j] += value
    P[j, i] += value


@njit(cache=True, error_model="numpy")
def _predict_wheels(s, P, d, turn, aside, q_f, q_t, way):  # type: ignore[no-untyped-def]
    """Move the state along a measured arc; P grows by the wheels' noise."""
    chord, a = _chord(d, turn), s[2] + turn / 2.0
    c, sn = math.cos(a), math.sin(a)
    dx, dy = chord * c - aside * sn, chord * sn + aside * c
    _carry(P, -dy, dx, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0)
    var_d, var_t = q_f * way, q_t * way
    gx, gy = -dy / 2.0, dx / 2.0  # a turn error acts on the chord by half of itself
    P[0, 0] += var_d * c * c + var_t * gx * gx
    P[1, 1] += var_d * sn * sn + var_t * gy * gy
    P[2, 2] += var_t
    _add_pair(P, 0, 1, var_d * c * sn + var_t * gx * gy)
    _add_pair(P, 0, 2, var_t * gx)
    _add_pair(P, 1, 2, var_t * gy)
    s[0] += dx
    s[1] += dy
    s[2] += turn


@njit(cache=True, error_model="numpy")
def settling_noise(h, tau, q):  # type: ignore[no-untyped-def]
    """Return variance of the way, its covariance with the speed and the speed's variance after h seconds of white
    acceleration of density q that is forgotten with the time constant tau.
    """
    lost = 1.0 - math.exp(-h / tau)
    speed = q * tau / 2.0 * lost * (2.0 - lost)
    cross = q * tau * tau / 2.0 * lost * lost
    if h < SHORT * tau:  # the difference below would lose its digits
        return q * h * h * h / 3.0 * (1.0 - 0.75 * h / tau), cross, speed
    return tau * tau * (q * h - 2.0 * q * tau * lost) + tau * tau * speed, cross, speed


@njit(cache=True, error_model="numpy")
def _predict_commands(s, P, h, V, W, tau_f, tau_t, q_f, q_t):  # type: ignore[no-untyped-def]
    """Let the speeds settle toward (V, W) for h seconds and move on the arc; P grows by
    random accelerations.
    """
    ef, et = math.exp(-h / tau_f), math.exp(-h / tau_t)
    gf, gt = tau_f * (1.0 - ef), tau_t * (1.0 - et)
    d = V * h + (s[3] - V) * gf
    turn = W * h + (s[4] - W) * gt
    chord, a = _chord(d, turn), s[2] + turn / 2.0
    c, sn = math.cos(a), math.sin(a)
    aside = sway(d, turn, (s[3] - V) * (ef - 1.0) * h, (s[4] - W) * (et - 1.0) * h)
    dx, dy = chord * c - aside * sn, chord * sn + aside * c
    _carry(P, -dy, dx, gf * c, gf * sn, -dy * gt / 2.0, dx * gt / 2.0, gt, ef, et)
    way, cross, speed = settling_noise(h, tau_f, q_f)
    P[0, 0] += way * c * c
    P[1, 1] += way * sn * sn
    P[3, 3] += speed
    _add_pair(P, 0, 1, way * c * sn)
    _add_pair(P, 0, 3, cross * c)
    _add_pair(P, 1, 3, cross * sn)
    way, cross, speed = settling_noise(h, tau_t, q_t)
    P[2, 2] += way
    P[4, 4] += speed
    _add_pair(P, 2, 4, cross)
    s[0] += dx
    s[1] += dy
    s[2] += turn
    s[3] = V + (s[3] - V) * ef
    s[4] = W + (s[4] - W) * et


@njit(cache=True, error_model="numpy")
def _forget(s, P, way, s_b):  # type: ignore[no-untyped-def]
    """Let the tracker's error forget itself over `way` metres of travel."""
    keep = math.exp(-way / BIAS_LENGTH)
    for i in (5, 6):
        s[i] *= keep
        for j in range(STATES):
            P[i, j] *= keep
        for j in range(STATES):
            P[j, i] *= keep
        P[i, i] += s_b * s_b * (1.0 - keep * keep)


@njit(cache=True, error_model="numpy")
def _update(s, P, PH, z, has_heading, used, p, v, w, e, S):  # type: ignore[no-untyped-def]
    """Compare with one measured pose: write innovation e (3,) and its variance S (3, 3); correct s and P.

    PH : scratch of shape (STATES, 3).
    """
    c, sn = math.cos(s[2]), math.sin(s[2])
    px, py, psi = p[0], p[1], p[2]
    x_theta, y_theta = -sn * px - c * py, c * px - sn * py
    told = 1.0 if has_heading else 0.0
    e[0] = z[0] - (s[0] + c * px - sn * py + s[5])
    e[1] = z[1] - (s[1] + sn * px + c * py + s[6])
    difference = z[2] - s[2] - psi
    e[2] = told * math.atan2(math.sin(difference), math.cos(difference))
    for i in range(STATES):
        PH[i, 0] = P[i, 0] + x_theta * P[i, 2] + P[i, 5]
        PH[i, 1] = P[i, 1] + y_theta * P[i, 2] + P[i, 6]
        PH[i, 2] = told * P[i, 2]
    for j in range(3):
        S[0, j] = PH[0, j] + x_theta * PH[2, j] + PH[5, j]
        S[1, j] = PH[1, j] + y_theta * PH[2, j] + PH[6, j]
        S[2, j] = told * PH[2, j]
    gx, gy, gt = v * c + w * x_theta, v * sn + w * y_theta, told * w
    S[0, 0] += p[3] + p[5] * gx * gx
    S[1, 1] += p[3] + p[5] * gy * gy
    S[2, 2] += (p[4] if has_heading else 1.0) + p[5] * gt * gt
    _add_pair(S, 0, 1, p[5] * gx * gy)
    _add_pair(S, 0, 2, p[5] * gx * gt)
    _add_pair(S, 1, 2, p[5] * gy * gt)
    if used:
        _correct(s, P, PH, e, S)


@njit(cache=True, error_model="numpy")
def _correct(s, P, PH, e, S):  # type: ignore[no-untyped-def]
    """Correct state and covariance: K = P H' S^-1, the inverse by cofactors."""
    c00, c01 = S[1, 1] * S[2, 2] - S[1, 2] * S[1, 2], S[0, 2] * S[1, 2] - S[0, 1] * S[2, 2]
    c02, c11 = S[0, 1] * S[1, 2] - S[0, 2] * S[1, 1], S[0, 0] * S[2, 2] - S[0, 2] * S[0, 2]
    c12, c22 = S[0, 1] * S[0, 2] - S[0, 0] * S[1, 2], S[0, 0] * S[1, 1] - S[0, 1] * S[0, 1]
    share = 1.0 / (S[0, 0] * c00 + S[0, 1] * c01 + S[0, 2] * c02)
    for i in range(STATES):
        a, b, c = PH[i, 0] * share, PH[i, 1] * share, PH[i, 2] * share
        k0, k1, k2 = a * c00 + b * c01 + c * c02, a * c01 + b * c11 + c * c12, a * c02 + b * c12 + c * c22
        s[i] += k0 * e[0] + k1 * e[1] + k2 * e[2]
        for j in range(i, STATES):
            P[i, j] -= k0 * PH[j, 0] + k1 * PH[j, 1] + k2 * PH[j, 2]
            P[j, i] = P[i, j]


@njit(cache=True, error_model="numpy")
def innovations(mode, steps, z, heading_known, used, start, p, dyn):  # type: ignore[no-untyped-def]
    """Run the filter.

    Parameters
    ----------
    mode : BY_WHEELS or BY_COMMANDS.
    steps : array, shape (m, 6): duration [s]; d [m] or V [m/s]; turn [rad] or W [rad/s]; way [m] or 1 for a
        stale command; row of the pose measured at the end of the step, -1 for none; sway [m] (wheels only).
    z : array, shape (n, 3): x, y [m], theta [rad]; heading_known, used : arrays of bool, shape (n,).
    start : array (x, y, theta, theta's variance).
    p : array (px, py, psi, r_xy, r_theta, r_time); dyn : array (tau_f, tau_t, q_f, q_t, s_b).

    Returns
    -------
    e : array, shape (n, 3); S : array, shape (n, 3, 3). Rows without a heading have e[2] = 0.
    """
    n = z.shape[0]
    e = np.zeros((n, 3))
    S = np.zeros((n, 3, 3))
    for k in range(n):
        S[k, 0, 0], S[k, 1, 1], S[k, 2, 2] = 1.0, 1.0, 1.0
    s = np.zeros(STATES)
    s[0], s[1], s[2] = start[0], start[1], start[2]
    P, PH = np.zeros((STATES, STATES)), np.empty((STATES, 3))
    P[0, 0], P[1, 1], P[2, 2] = DIFFUSE_POSITION, DIFFUSE_POSITION, start[3]
    P[3, 3], P[4, 4] = FIRST_SPEED**2, FIRST_TURN_RATE**2
    P[5, 5], P[6, 6] = dyn[4] ** 2, dyn[4] ** 2
    for i in range(steps.shape[0]):
        h = steps[i, 0]
        if mode == BY_WHEELS:
            _predict_wheels(s, P, steps[i, 1], steps[i, 2], steps[i, 5], dyn[2], dyn[3], steps[i, 3])
            _forget(s, P, steps[i, 3], dyn[4])
        elif h > 0.0:
            q_f, q_t = dyn[2], dyn[3]
            if steps[i, 3] > 0.5:
                q_f, q_t = q_f + FIRST_SPEED**2 / UNKNOWN_AFTER, q_t + FIRST_TURN_RATE**2 / UNKNOWN_AFTER
            asked = abs(steps[i, 1]) + abs(steps[i, 2])
            if asked == 0.0 and abs(s[3]) < STILL_SPEED and abs(s[4]) < STILL_TURN_RATE:
                q_f, q_t = q_f * STILL_NOISE, q_t * STILL_NOISE
            _predict_commands(s, P, h, steps[i, 1], steps[i, 2], dyn[0], dyn[1], q_f, q_t)
            _forget(s, P, h * (abs(s[3]) + BIAS_LENGTH / 10.0 * abs(s[4])), dyn[4])
        row = int(steps[i, 4])
        if row >= 0:
            v, w = s[3], s[4]
            if mode == BY_WHEELS and h > 0.0:
                v, w = steps[i, 1] / h, steps[i, 2] / h
            _update(s, P, PH, z[row], heading_known[row], used[row], p, v, w, e[row], S[row])
    return e, S
