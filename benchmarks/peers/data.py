"""What every peer is given: smoothed states and accelerations of a recording, and windows to be judged on.

Poses are smoothed by local quadratics (Savitzky-Golay) and the commands by the same window ("matched smoothing"), so
that both sides of a regression saw the same filter; without it no regression comes near the floor.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fsm_calib.recording import Recording, read_recording

STEP = 0.05  # s, grid of the regressions
WIDTH = 0.25  # s, half the smoothing window
HORIZON = 2.0  # s, of the judged predictions
RIM = 0.5  # s between the starts of two windows
HOLE = 0.25  # s without a pose: no window, no regression row
RADIUS, AXLE = 0.0318, 0.1  # m, the nominal robot


@dataclass(frozen=True)
class Track:
    """One drive on a regular grid, arrays of shape (n,).

    t [s]; x, y [m], theta [rad]; v, side [m/s], w [rad/s] of the tracked point in the body's frame; dv [m/s2], dw
    [rad/s2]; left, right: smoothed commands [1]; d_left, d_right: their rates [1/s]; good: whether poses were near;
    measured: raw poses (m, 4); edges, held: raw commands (k,), (k, 2).
    """

    t: np.ndarray
    x: np.ndarray
    y: np.ndarray
    theta: np.ndarray
    v: np.ndarray
    side: np.ndarray
    w: np.ndarray
    dv: np.ndarray
    dw: np.ndarray
    left: np.ndarray
    right: np.ndarray
    d_left: np.ndarray
    d_right: np.ndarray
    good: np.ndarray
    measured: np.ndarray
    edges: np.ndarray
    held: np.ndarray

    def commands(self, times: np.ndarray) -> np.ndarray:
        """Return the commands that hold at `times`, shape (..., 2)."""
        row = np.searchsorted(self.edges, times, side="right") - 1
        return np.where((row >= 0)[..., None], self.held[np.maximum(row, 0)], 0.0)


def read_track(folder: Path) -> Track:
    """Read one drive."""
    recording: Recording = read_recording(folder)
    pose, command = recording.pose, recording.command
    theta = np.unwrap(pose.theta)
    poses = np.stack([pose.time, pose.x, pose.y, theta], axis=1)
    t = np.arange(pose.time[0] + WIDTH, pose.time[-1] - WIDTH, STEP)
    smooth = local_quadratic(pose.time, poses[:, 1:], t)
    (x, y, angle), (vx, vy, w), (ax, ay, dw) = smooth[:, 0].T, smooth[:, 1].T, smooth[:, 2].T
    c, s = np.cos(angle), np.sin(angle)
    v, side = c * vx + s * vy, -s * vx + c * vy
    dv = c * ax + s * ay + w * side
    fine = np.arange(t[0] - WIDTH, t[-1] + WIDTH, STEP / 5)
    held = np.stack([command.left, command.right], axis=1)
    row = np.searchsorted(command.time, fine, side="right") - 1
    levels = np.where((row >= 0)[:, None], held[np.maximum(row, 0)], 0.0)
    same = local_quadratic(fine, levels, t)
    near = np.abs(np.searchsorted(pose.time, t - HOLE) - np.searchsorted(pose.time, t + HOLE)) >= 4
    return Track(
        t, x, y, angle, v, side, w, dv, dw, same[:, 0, 0], same[:, 0, 1], same[:, 1, 0], same[:, 1, 1], near,
        poses, command.time, held,
    )  # fmt: skip


def local_quadratic(time: np.ndarray, values: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return value, rate and second derivative of local quadratics, shape (n, 3, d), robust against single outliers."""
    result = np.zeros((len(at), 3, values.shape[1]))
    for i, moment in enumerate(at):
        low, high = np.searchsorted(time, [moment - WIDTH, moment + WIDTH])
        low, high = (low, high) if high - low >= 4 else (max(low - 3, 0), min(high + 3, len(time)))
        tau = time[low:high] - moment
        design = np.stack([np.ones_like(tau), tau, tau**2 / 2.0], axis=1)
        weight = np.ones(len(tau))
        for _ in range(4):
            fit = np.linalg.lstsq(design * weight[:, None], values[low:high] * weight[:, None], rcond=None)[0]
            left_over = np.abs(values[low:high] - design @ fit)
            far = (left_over / (1.4826 * np.median(left_over, axis=0) + 1e-6)).max(axis=1)
            weight = 1.0 / np.maximum(far / 3.0, 1.0) ** 2
        result[i] = fit
    return result


@dataclass(frozen=True)
class Windows:
    """Starts of 2 s windows of one drive: rows of its grid, and the measured poses they are judged by."""

    rows: np.ndarray
    ends: np.ndarray  # measured pose nearest to the end of each window, shape (n, 3)
    lasts: np.ndarray  # s


def windows_of(track: Track) -> Windows:
    """Return windows that begin and end where poses were measured."""
    rows = np.arange(0, len(track.t) - int(HORIZON / STEP) - 1, int(RIM / STEP))
    end = track.t[rows] + HORIZON
    nearest = np.clip(np.searchsorted(track.measured[:, 0], end), 0, len(track.measured) - 1)
    close = np.abs(track.measured[nearest, 0] - end) < HOLE / 2
    keep = track.good[rows] & close
    rows, nearest = rows[keep], nearest[keep]
    return Windows(rows, track.measured[nearest, 1:], track.measured[nearest, 0] - track.t[rows])


def error_of(predicted: np.ndarray, windows: Windows) -> tuple[float, float]:
    """Return the median error of position [m] and heading [rad] at the end of the windows."""
    away = np.hypot(*(predicted[:, :2] - windows.ends[:, :2]).T)
    turn = np.abs(np.angle(np.exp(1j * (predicted[:, 2] - windows.ends[:, 2]))))
    return float(np.median(away)), float(np.median(turn))
