r"""The roll-out where no effect acts in a step: the equations of `dynamics` and `tyres` in local variables.

The general step reads from arrays what hooks may change. Without such a hook, with the mass over the axle's middle and
no play or friction in the gears, the same equations are a recurrence of a dozen numbers: a quarter faster, equal to the
general step but for the order of roundings (`tests/test_rollout_plain.py`).
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.arithmetic import ARITHMETIC
from fsm_calib.world2d.dynamics import CHARGE, FRICTION, GAIN, TYRE_RATIO, TYRE_SLIP, small_rotation
from fsm_calib.world2d.slots import (
    ANGLE,
    BASE_DRIVE,
    COM_X,
    COM_Y,
    HALF_AXLE,
    HEADING_COS,
    HEADING_SIN,
    HOOKED,
    INERTIA,
    LOAD,
    MASS,
    OMEGA,
    RADIUS,
    RIM,
    ROTATING,
    THETA,
    L,
    V,
    X,
    Y,
)
from fsm_calib.world2d.tyres import DAMPED_MIDDLE, line, settle, slips_at_crossing


@njit(**ARITHMETIC, forceinline=True)
def is_plain(W):
    """Return whether no hook acts in a step and the mass is over the axle's middle."""
    return W[HOOKED] == 0.0 and W[COM_X] == 0.0 and W[COM_Y] == 0.0


@njit(**ARITHMETIC, forceinline=True)
def push_body(h, m, inertia, half, wheel_l, wheel_r, v, l, omega):
    """Return the twist after the step: `dynamics.finish_step` with the centre of mass on the axle's middle."""
    stiff_l, slope_l, force_l = wheel_l
    stiff_r, slope_r, force_r = wheel_r
    b00, b02, b11 = slope_l + slope_r, half * (slope_r - slope_l), stiff_l + stiff_r
    b22, gyro, g = half * half * (slope_l + slope_r), m * omega, 0.5 * h
    r0 = h * (force_l + force_r - b00 * v + gyro * l - b02 * omega)
    r1 = h * (-gyro * v - b11 * l)
    r2 = h * (half * (force_r - force_l) - b02 * v - b22 * omega)
    a00, a11, a22, a01, a02 = m + g * b00, m + g * b11, inertia + g * b22, g * gyro, g * b02
    c00, c01, c02 = a11 * a22, a01 * a22, -a02 * a11
    inverse = 1.0 / (a00 * c00 + a01 * c01 + a02 * c02)
    dv = (c00 * r0 + c01 * r1 + c02 * r2) * inverse
    dl = (-c01 * r0 + (a00 * a22 - a02 * a02) * r1 + a02 * a01 * r2) * inverse
    dw = (c02 * r0 - a01 * a02 * r1 + (a00 * a11 + a01 * a01) * r2) * inverse
    return settle(v + dv), settle(l + dl), settle(omega + dw)


@njit(**ARITHMETIC)
def glide(P, W, S, late, times, level_l, total_l, level_r, total_r, samples, limit, out):
    """Drive a plain robot from the state S through the sample times [s]; `loop.run` explains the arguments."""
    m, inertia, half, rotating, base = W[MASS], W[INERTIA], W[HALF_AXLE], W[ROTATING], W[BASE_DRIVE]
    grip_l, grip_r = P[FRICTION] * W[LOAD], P[FRICTION] * W[LOAD + 1]
    gain_l, gain_r = P[CHARGE] * P[GAIN], P[CHARGE] * P[GAIN + 1]
    least2 = P[TYRE_SLIP] * P[TYRE_SLIP]
    ratio2 = P[TYRE_RATIO] * P[TYRE_RATIO]
    radius_l, radius_r, lag = W[RADIUS], W[RADIUS + 1], 1.0 / DAMPED_MIDDLE
    x, y, theta, v, l, omega = S[X], S[Y], S[THETA], S[V], S[L], S[OMEGA]
    c, s, rim_l, rim_r = S[HEADING_COS], S[HEADING_SIN], S[RIM], S[RIM + 1]
    angle_l, angle_r = S[ANGLE], S[ANGLE + 1]
    slip_l = slip_r = trend_l = trend_r = 0.0
    last, j, t = times.size - 1, 0, samples[0] - late
    while j < last and times[j + 1] <= t:
        j += 1
    at_l, at_r = total_l[j] + level_l[j] * (t - times[j]), total_r[j] + level_r[j] * (t - times[j])
    now = samples[0]
    for k in range(samples.size - 1):
        span = samples[k + 1] - samples[k]
        n = max(1, math.ceil(span / limit - 0.02))
        h = span / n
        per_second, inert = 1.0 / h, rotating / (DAMPED_MIDDLE * h)
        drive = base + inert
        share = 1.0 / drive
        for i in range(n):
            t = samples[k] + (i + 1) * h - late
            while j < last and times[j + 1] <= t:
                j += 1
            to_l, to_r = total_l[j] + level_l[j] * (t - times[j]), total_r[j] + level_r[j] * (t - times[j])
            free_l = (base * gain_l * ((to_l - at_l) * per_second) + inert * rim_l) * share
            free_r = (base * gain_r * ((to_r - at_r) * per_second) + inert * rim_r) * share
            at_l, at_r, v_l, v_r = to_l, to_r, v - half * omega, v + half * omega
            floor2 = l * l + least2 + ratio2 * 0.5 * (v_l * v_l + v_r * v_r)
            new_l, new_r = slips_at_crossing(
                (free_l - v_l, free_r - v_r),
                (drive, drive),
                (grip_l, grip_r),
                floor2,
                (slip_l + trend_l, slip_r + trend_r),
            )
            trend_l, trend_r, slip_l, slip_r = new_l - slip_l, new_r - slip_r, new_l, new_r
            wheel_l = line(slip_l, v_l, drive, grip_l, floor2)
            wheel_r = line(slip_r, v_r, drive, grip_r, floor2)
            v1, l1, omega1 = push_body(h, m, inertia, half, wheel_l, wheel_r, v, l, omega)
            mean_v, mean_omega = 0.5 * (v + v1), 0.5 * (omega + omega1)
            mean_l = free_l - share * (wheel_l[2] - wheel_l[1] * (mean_v - half * mean_omega))
            mean_r = free_r - share * (wheel_r[2] - wheel_r[1] * (mean_v + half * mean_omega))
            turned_l, turned_r = (
                settle(rim_l + (mean_l - rim_l) * lag),
                settle(rim_r + (mean_r - rim_r) * lag),
            )
            angle_l += h * 0.5 * (rim_l + turned_l) / radius_l
            angle_r += h * 0.5 * (rim_r + turned_r) / radius_r
            rim_l, rim_r = turned_l, turned_r
            dc, ds = small_rotation(h * mean_omega)
            c1, s1 = c * dc - s * ds, s * dc + c * ds
            x += h * 0.5 * (c * v - s * l + c1 * v1 - s1 * l1)
            y += h * 0.5 * (s * v + c * l + s1 * v1 + c1 * l1)
            theta, c, s, v, l, omega = theta + h * mean_omega, c1, s1, v1, l1, omega1
            now += h
        out[k + 1, 0], out[k + 1, 1], out[k + 1, 2] = x, y, theta
        out[k + 1, 3], out[k + 1, 4], out[k + 1, 5] = v, l, omega
        out[k + 1, 6], out[k + 1, 7], out[k + 1, 8], out[k + 1, 9] = angle_l, angle_r, rim_l, rim_r
        out[k + 1, 10], out[k + 1, 11] = now, 1.0 if abs(v) + abs(l) + abs(omega) > 0.0 else 0.0
