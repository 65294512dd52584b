"""The loop over steps, as plain text that `kernel` weaves together with the effects' hooks and compiles.

The functions here run the bare base robot as they stand (`begin`, `shape`, `delay`, `step` below know no
effect); `kernel` puts generated functions of the same names in their place. A drive is held commands: level j
acts from ``times[j]`` to ``times[j + 1]``. Levels pass the static maps first and are then averaged over each
step from their running integral, so that a delay moves the result smoothly and no edge is ever missed.
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.arithmetic import ARITHMETIC, EXACT
from fsm_calib.world2d.dynamics import (
    begin_base,
    begin_step,
    finish_step,
    look_around,
    share_load,
)
from fsm_calib.world2d.plain import glide, is_plain
from fsm_calib.world2d.slots import (
    COM_X,
    COM_Y,
    COMMAND,
    COS,
    HALF_AXLE,
    HEADING_COS,
    HEADING_SIN,
    INERTIA,
    MASS,
    MEAN_OMEGA,
    MEAN_VX,
    MEAN_VY,
    NEXT_VX,
    NEXT_VY,
    OMEGA,
    PLACE_X,
    PLACE_Y,
    RIM,
    ROLL,
    SIN,
    STEP,
    THETA,
    TIME,
    L,
    V,
    X,
    Y,
)

OUTPUTS = 12
"""Columns of a result: x, y, theta, v, l, omega, wheel angles left and right, rim speeds left and right,
time, moved."""


@njit(**ARITHMETIC)
def begin(P, on, W):
    """Prepare the workbench for a roll-out."""
    begin_base(P, W)
    share_load(P, W)


@njit(**ARITHMETIC)
def shape(P, on, u, side):
    """Map a held command [1] of one wheel statically."""
    return u


@njit(**ARITHMETIC)
def delay(P, on):
    """Return how much later commands act [s]."""
    return 0.0


@njit(**ARITHMETIC)
def step(P, on, S, W):
    """Make one step of the length and with the commands that lie in W."""
    begin_step(P, W)
    finish_step(S, W)


@njit(**ARITHMETIC)
def integrate_levels(P, on, times, levels, side, shaped, total):
    """Fill in the shaped levels and their running integral [s] at the breakpoints, each of shape (n,)."""
    for j in range(times.size):
        shaped[j] = shape(P, on, levels[j], side)
        total[j] = total[j - 1] + shaped[j - 1] * (times[j] - times[j - 1]) if j > 0 else 0.0


@njit(**ARITHMETIC)
def look_at_track(W, track, k, part):
    """Take place, heading and roll from the track, `part` of the way from sample k to k + 1."""
    W[PLACE_X] = track[k, 0] + part * (track[k + 1, 0] - track[k, 0])
    W[PLACE_Y] = track[k, 1] + part * (track[k + 1, 1] - track[k, 1])
    theta = track[k, 2] + part * (track[k + 1, 2] - track[k, 2])
    W[COS], W[SIN] = math.cos(theta), math.sin(theta)
    W[ROLL] = track[k, 3] + part * (track[k + 1, 3] - track[k, 3])
    W[ROLL + 1] = track[k, 4] + part * (track[k + 1, 4] - track[k, 4])


@njit(**ARITHMETIC)
def keep(out, k, S):
    """Write the state into row k of the result."""
    for i in range(10):
        out[k, i] = S[i]
    out[k, 10] = S[TIME]
    out[k, 11] = 1.0 if abs(S[V]) + abs(S[L]) + abs(S[OMEGA]) > 0.0 else 0.0


@njit(**ARITHMETIC)
def run(P, on, S, W, levels, looks, times, left, right, samples, start, track, limit, out):
    """Drive the robot through the sample times [s] and write one row a sample, shape (n, 12).

    `on` (flags, one an effect), `S`, `W` and `levels` (4 rows of the length of `times`) room to work in, `looks`
    (0: no place needed, 1: simulated pose, 2: track of shape (n, 5) at the sample times: x, y, theta, wheel angles),
    `start` (6: pose and twist of the axle), `limit` the longest step [s]. Each interval between samples is cut into
    equal steps.
    """
    for i in range(S.size):
        S[i] = start[i] if i < 6 else 0.0
    S[TIME] = samples[0]
    S[HEADING_COS], S[HEADING_SIN] = math.cos(S[THETA]), math.sin(S[THETA])
    begin(P, on, W)
    S[RIM], S[RIM + 1] = S[V] - W[HALF_AXLE] * S[OMEGA], S[V] + W[HALF_AXLE] * S[OMEGA]
    level_l, total_l, level_r, total_r = levels[0], levels[1], levels[2], levels[3]
    integrate_levels(P, on, times, left, 0, level_l, total_l)
    integrate_levels(P, on, times, right, 1, level_r, total_r)
    late, last, j = delay(P, on), times.size - 1, 0
    keep(out, 0, S)
    if is_plain(W):
        glide(P, W, S, late, times, level_l, total_l, level_r, total_r, samples, limit, out)
        return
    t = samples[0] - late
    while j < last and times[j + 1] <= t:
        j += 1
    at_l, at_r = total_l[j] + level_l[j] * (t - times[j]), total_r[j] + level_r[j] * (t - times[j])
    for k in range(samples.size - 1):
        span = samples[k + 1] - samples[k]
        n = max(1, math.ceil(span / limit - 0.02))
        h = span / n
        W[STEP], per_second = h, 1.0 / h
        for i in range(n):
            t = samples[k] + (i + 1) * h - late
            while j < last and times[j + 1] <= t:
                j += 1
            to_l, to_r = total_l[j] + level_l[j] * (t - times[j]), total_r[j] + level_r[j] * (t - times[j])
            W[COMMAND], W[COMMAND + 1] = (to_l - at_l) * per_second, (to_r - at_r) * per_second
            at_l, at_r = to_l, to_r
            if looks == 1:
                look_around(S, W)
            elif looks == 2:
                look_at_track(W, track, k, (i + 0.5) / n)
            step(P, on, S, W)
        keep(out, k + 1, S)


@njit(**ARITHMETIC)
def run_many(Ps, ons, S, W, levels, looks, times, left, right, samples, starts, track, limit, out):
    """Run every parameter vector of Ps, shape (k, p), from starts, shape (k, 6); out has shape (k, n, 12)."""
    for i in range(Ps.shape[0]):
        run(
            Ps[i],
            ons[i],
            S,
            W,
            levels,
            looks[i],
            times,
            left,
            right,
            samples,
            starts[i],
            track,
            limit,
            out[i],
        )


@njit(**ARITHMETIC)
def single_step(P, on, S, W, u_left, u_right, h):
    """Make one step of a robot that lives elsewhere: mean shaped commands [1], length h [s]."""
    W[STEP], W[COMMAND], W[COMMAND + 1] = h, u_left, u_right
    look_around(S, W)
    step(P, on, S, W)


@njit(**EXACT)
def ride(P, on, S, W, body, commands, h, out):
    """Make one step [s] for each row of mean shaped commands [1] of a robot that lives in pymunk.

    `body`: x, y, theta, velocity and yaw rate of the centre of mass in `world` (0 to 5), at the end those after
    the steps; then what pymunk is to be given for the last of them: mean velocity and yaw rate (6 to 8), force
    and torque (9 to 11). Between the steps the body moves as pymunk's integrator moves one that nothing
    touches and whose centre of mass is the axle's centre (Chipmunk 7, cpBody.c, cpBodyUpdatePosition and
    cpBodyUpdateVelocity without gravity and damping), bit for bit. `out`, shape (n, 3): the poses.
    """
    x, y, theta, vx, vy, omega = body[0], body[1], body[2], body[3], body[4], body[5]
    push, twist = W[MASS] / h, W[INERTIA] / h
    mass_inverse, inertia_inverse = 1.0 / W[MASS], 1.0 / W[INERTIA]
    for k in range(commands.shape[0]):
        c, s = math.cos(theta), math.sin(theta)
        S[X], S[Y], S[THETA] = x, y, theta
        S[HEADING_COS], S[HEADING_SIN] = c, s
        S[V] = c * vx + s * vy + omega * W[COM_Y]
        S[L] = c * vy - s * vx - omega * W[COM_X]
        S[OMEGA] = omega
        single_step(P, on, S, W, commands[k, 0], commands[k, 1], h)
        body[6], body[7], body[8] = W[MEAN_VX], W[MEAN_VY], W[MEAN_OMEGA]
        body[9] = push * (W[NEXT_VX] - body[6])
        body[10] = push * (W[NEXT_VY] - body[7])
        body[11] = twist * (S[OMEGA] - body[8])
        x, y, theta = x + body[6] * h, y + body[7] * h, theta + body[8] * h
        vx = body[6] + body[9] * mass_inverse * h
        vy = body[7] + body[10] * mass_inverse * h
        omega = body[8] + body[11] * inertia_inverse * h
        out[k, 0], out[k, 1], out[k, 2] = x, y, theta
    body[0], body[1], body[2], body[3], body[4], body[5] = x, y, theta, vx, vy, omega
