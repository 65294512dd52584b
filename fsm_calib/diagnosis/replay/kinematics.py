"""The kinematics that identification needs: two wheels that roll, arcs, the sensor's motion on the robot.

    d = (s_r + s_l) / 2        dtheta = (s_r - s_l) / b        with s_i = a_i q_i

q_i: what wheel i measured (rad, tick or m); a_i: its scale (radius [m], metres per tick, or 1); b: axle
length [m]. Over one interval the rates are constant, so the base moves on an arc of length d and turn dtheta:
with h = dtheta / 2 and chord c = d sin(h) / h, dx = c cos(h), dy = c sin(h).
"""

from __future__ import annotations

import numpy as np

from fsm_calib.types import FloatArray


def body_motion(
    left: FloatArray, right: FloatArray, scale_left: float, scale_right: float, axle: float
) -> tuple[FloatArray, FloatArray]:
    """Return path length d [m] and turn dtheta [rad] of the base over each interval, shape (n,)."""
    s_left, s_right = scale_left * left, scale_right * right
    return (s_right + s_left) / 2.0, (s_right - s_left) / axle


def arc(d: FloatArray, dtheta: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the chord (dx, dy) [m] of an arc in the frame at its start."""
    chord = d * np.sinc(dtheta / (2.0 * np.pi))
    return chord * np.cos(dtheta / 2.0), chord * np.sin(dtheta / 2.0)


def sensor_motion(d: FloatArray, dtheta: FloatArray, sensor: FloatArray) -> FloatArray:
    """Return the sensor's displacement (dx, dy, dtheta), shape (n, 3), in the sensor's frame at the start.

    `sensor` = (x, y, theta) [m, m, rad] on the base; displacement = (-)sensor (+) arc (+) sensor, as in
    Censi, Franchi, Marchionni, Oriolo 2013 (DOI 10.1109/TRO.2012.2226380), eq. 5.
    """
    x, y, theta = sensor
    dx, dy = arc(d, dtheta)
    c, s = np.cos(dtheta), np.sin(dtheta)
    base_x = dx + c * x - s * y - x
    base_y = dy + s * x + c * y - y
    ct, st = np.cos(theta), np.sin(theta)
    return np.stack([ct * base_x + st * base_y, -st * base_x + ct * base_y, dtheta], axis=1)


def dead_reckon(
    d: FloatArray, dtheta: FloatArray, start: tuple[float, float, float]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Chain arcs from `start` (x, y, theta); return x, y [m] and theta [rad], shape (n + 1,) each."""
    x0, y0, theta0 = start
    theta = theta0 + np.concatenate([[0.0], np.cumsum(dtheta)])
    dx, dy = arc(d, dtheta)
    c, s = np.cos(theta[:-1]), np.sin(theta[:-1])
    x = x0 + np.concatenate([[0.0], np.cumsum(c * dx - s * dy)])
    y = y0 + np.concatenate([[0.0], np.cumsum(s * dx + c * dy)])
    return x, y, theta
