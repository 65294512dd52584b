"""How visible an effect is: what it adds to 2 s displacements that no calibration takes up, against noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.dart_robots.robots import Sensing
from benchmarks.dart_robots.sensing import Poses, seen
from benchmarks.dart_robots.simulate import within
from benchmarks.dart_robots.truth import Moments, Trajectory, Truth

LENGTH = 2.0  # s
STRIDE = 0.5  # s
HZ = 50.0
AFTER = 0.3  # s that a push or fault is felt after its end


@dataclass(frozen=True)
class Ratio:
    """The ratio of position and of heading, and the share of windows that the effect touches."""

    position: float
    heading: float
    touched: float

    @property
    def value(self) -> float:
        """The larger one."""
        return max(self.position, self.heading)


def _stamps(drive: Trajectory) -> np.ndarray:
    return np.arange(0.0, float(drive.time[-1]) - 0.05, 1.0 / HZ)


def _starts(count: int) -> tuple[np.ndarray, int]:
    long = round(LENGTH * HZ)
    return np.arange(0, count - long, round(STRIDE * HZ)), long


def displacements(poses: Poses) -> np.ndarray:
    """Return (windows, 3): dx, dy in the own frame at each window's start, and dtheta."""
    first, long = _starts(len(poses.time))
    last = first + long
    dx, dy = poses.x[last] - poses.x[first], poses.y[last] - poses.y[first]
    cos, sin = np.cos(poses.theta[first]), np.sin(poses.theta[first])
    return np.stack(
        [cos * dx + sin * dy, cos * dy - sin * dx, poses.theta[last] - poses.theta[first]], axis=1
    )


def kinematic(truth: Truth, drive: Trajectory, change: tuple[float, float, float, float]) -> Poses:
    """Return the poses of a plain unicycle with lagging wheels; `change`: gains, axle (shares), lag [s]."""
    time = _stamps(drive)
    row = np.searchsorted(drive.command_time, time + 1e-9, side="right") - 1
    body, motors = truth.body, truth.drive
    lag = 0.12 + change[3]
    keep = np.exp(-1.0 / HZ / lag)
    speeds = []
    for side, commands in enumerate((drive.command_left, drive.command_right)):
        wanted = commands[row] * motors.top_rate * body.radius[side] * (1.0 + change[side])
        speed, level = np.empty(len(time)), 0.0
        for k, value in enumerate(wanted):
            level = value + (level - value) * keep
            speed[k] = level
        speeds.append(speed)
    forward = (speeds[0] + speeds[1]) / 2.0
    turn = (speeds[1] - speeds[0]) / (body.axle * (1.0 + change[2]))
    theta = np.concatenate([[0.0], np.cumsum(turn[:-1]) / HZ])
    middle = theta + turn / HZ / 2.0
    x = np.concatenate([[0.0], np.cumsum(forward * np.cos(middle))[:-1] / HZ])
    y = np.concatenate([[0.0], np.cumsum(forward * np.sin(middle))[:-1] / HZ])
    return Poses(time, x, y, theta)


def touched(truth: Truth, drive: Trajectory, moments: Moments, what: str) -> np.ndarray:
    """Return which windows an effect of a place or a moment touches; all where it is of neither."""
    time = _stamps(drive)
    first, long = _starts(len(time))
    if not what:
        return np.ones(len(first), dtype=bool)
    x, y = np.interp(time, drive.time, drive.x), np.interp(time, drive.time, drive.y)
    if what == "push":
        since = time - moments.push_start
        on = (since >= 0) & (since < truth.place.push_time + AFTER)
    elif what == "fault":
        on = (time >= moments.fault_start) & (time < moments.fault_end + AFTER)
    else:
        patch = {"rough": truth.place.rough, "slippery": truth.place.slippery, "seam": truth.watch.seam}[what]
        on = np.zeros(len(time), dtype=bool)
        if patch is not None:
            theta = np.interp(time, drive.time, drive.theta)
            half = 0.0 if what == "seam" else truth.body.axle / 2
            for side in (-half, half):
                on |= np.vectorize(within)(patch, x - side * np.sin(theta), y + side * np.cos(theta))
    return np.array([bool(on[k : k + long + 1].any()) for k in first])


def noise(sensing: Sensing, moved: np.ndarray) -> tuple[float, float]:
    """Return the standard deviations of a 2 s displacement's position (an axis) and heading."""
    far = float(np.mean(moved[:, 0] ** 2 + moved[:, 1] ** 2))
    position = np.sqrt(2.0 * sensing.position_sd**2 + sensing.heading_sd**2 * far / 2.0)
    return float(position), float(np.sqrt(2.0)) * sensing.heading_sd


@dataclass(frozen=True, eq=False)
class Drives:
    """The same commands with and without an effect, and what happened when."""

    with_it: Trajectory
    without: Trajectory
    moments: Moments


def ratio(truth: Truth, plain: Truth, drives: list[Drives], sensing: Sensing, what: str = "") -> Ratio:
    """Return how visible the difference between two robots is over some drives."""
    rest, columns, on, moved = [], [], [], []
    for drive in drives:
        stamps = _stamps(drive.with_it)
        base = displacements(seen(drive.without, plain.watch, stamps))
        rest.append(displacements(seen(drive.with_it, truth.watch, stamps)) - base)
        zero = displacements(kinematic(plain, drive.without, (0.0, 0.0, 0.0, 0.0)))
        step = 0.01
        column = []
        for k in range(4):
            change = [0.0, 0.0, 0.0, 0.0]
            change[k] = step
            moving = displacements(kinematic(plain, drive.without, tuple(change)))  # type: ignore[arg-type]
            column.append((moving - zero) / step)
        columns.append(np.stack(column, axis=-1))
        on.append(touched(truth, drive.with_it, drive.moments, what))
        moved.append(base)
    difference, matrix, mask = np.concatenate(rest), np.concatenate(columns), np.concatenate(on)
    position, heading = noise(sensing, np.concatenate(moved))
    scale = np.array([position, position, heading])
    rows = (matrix / scale[None, :, None]).reshape(-1, 4)
    values = (difference / scale).reshape(-1)
    answer = np.linalg.lstsq(rows, values, rcond=None)[0]
    left = (values - rows @ answer).reshape(-1, 3)[mask]
    if not len(left):
        return Ratio(1.0, 1.0, 0.0)
    square = np.mean(left**2, axis=0)
    return Ratio(
        float(np.sqrt(1.0 + (square[0] + square[1]) / 2.0)),
        float(np.sqrt(1.0 + square[2])),
        float(np.mean(mask)),
    )
