"""How large an effect is: what it does to displacements beyond what a first-order kinematic robot could take
up, over noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from benchmarks.physx_robots.laws import Reported
from benchmarks.physx_robots.robots import Robot, Sensing
from benchmarks.physx_robots.sensing import displacements
from benchmarks.physx_robots.simulate import Drive

GRID = 0.1  # s between noise-free poses
WINDOW, STRIDE = 20, 5  # grid steps: displacements over 2 s, one every 0.5 s
DELTA = 0.01  # share by which the kinematic robot's four numbers are changed


@dataclass(frozen=True)
class Compared:
    """One run with and without an effect, and where a local effect acts (on the drive's grid; None = everywhere)."""

    drive: Drive
    with_effect: Reported
    without: Reported
    mask: np.ndarray | None


@dataclass(frozen=True)
class Size:
    """ratio; rms of position and heading over noise; how many windows of each run counted."""

    ratio: float
    position: float
    heading: float
    windows: tuple[int, ...]

    @property
    def rms(self) -> float:
        """The larger of the two."""
        return max(self.position, self.heading)


def windows_of(poses: np.ndarray) -> np.ndarray:
    """Return the displacements over 2 s of poses on the grid."""
    start = np.arange(0, len(poses) - WINDOW, STRIDE)
    return displacements(poses, start, start + WINDOW)


def on_grid(poses: Reported, end: float) -> np.ndarray:
    """Return (x, y, yaw) every 0.1 s of the stamps."""
    times = np.arange(0.0, end, GRID)
    return np.stack([np.interp(times, poses["stamp"], poses[k]) for k in ("x", "y", "yaw")], axis=1)


def _kinematic(robot: Robot, drive: Drive, changes: np.ndarray) -> np.ndarray:
    """Return the poses every 0.1 s of a first-order robot; changes: shares of left gain, right gain, axle, time
    constant.
    """
    step = 0.01
    row = np.clip(np.searchsorted(drive.command_time, drive.time, side="right") - 1, 0, None)
    told = drive.command[row] * robot.speed * (1.0 + changes[:2])
    tau = 0.7 * robot.lag * (1.0 + changes[3])
    keep = np.exp(-step / tau)
    speed = lfilter([1.0 - keep], [1.0, -keep], told, axis=0)
    yaw = np.cumsum((speed[:, 1] - speed[:, 0]) / (robot.axle * (1.0 + changes[2]))) * step
    ahead = 0.5 * (speed[:, 0] + speed[:, 1]) * step
    poses = np.stack([np.cumsum(ahead * np.cos(yaw)), np.cumsum(ahead * np.sin(yaw)), yaw], axis=1)
    return poses[:: round(GRID / step)]


def _columns(robot: Robot, drive: Drive) -> np.ndarray:
    """Return what small changes of the four numbers do to the displacements: (windows, 3, 4)."""
    base = windows_of(_kinematic(robot, drive, np.zeros(4)))
    return np.stack(
        [(windows_of(_kinematic(robot, drive, row)) - base) / DELTA for row in np.eye(4) * DELTA], axis=2
    )


def noise_of(sensing: Sensing) -> np.ndarray:
    """Return the noise of a displacement: x, y [m], yaw [rad]."""
    return np.sqrt(2.0) * np.array([sensing.position_sd, sensing.position_sd, sensing.heading_sd])


def _touching(run: Compared, count: int) -> np.ndarray:
    if run.mask is None:
        return np.ones(count, dtype=bool)
    mask = run.mask[:: round(GRID / 0.01)]
    return np.array([mask[i : i + WINDOW + 1].any() for i in range(0, count * STRIDE, STRIDE)])


def size_of(robot: Robot, runs: Sequence[Compared]) -> Size:
    """Return the size of an effect over some runs."""
    noise = noise_of(robot.sensing)
    differ, columns, counted = [], [], []
    for run in runs:
        end = float(run.drive.time[-1]) + 0.01
        change = windows_of(on_grid(run.with_effect, end)) - windows_of(on_grid(run.without, end))
        column = _columns(robot, run.drive)
        count = min(len(change), len(column))
        differ.append(change[:count] / noise)
        columns.append(column[:count] / noise[:, None])
        counted.append(_touching(run, count))
    change, column = np.concatenate(differ), np.concatenate(columns)
    fit = np.linalg.lstsq(column.reshape(-1, 4), change.ravel(), rcond=None)[0]
    left = (change - column @ fit)[np.concatenate(counted)]
    if not len(left):
        return Size(1.0, 0.0, 0.0, tuple(0 for _ in runs))
    position, heading = float(np.sqrt(np.mean(left[:, :2] ** 2))), float(np.sqrt(np.mean(left[:, 2] ** 2)))
    ratio = float(np.sqrt(1.0 + max(position, heading) ** 2))
    return Size(ratio, position, heading, tuple(int(c.sum()) for c in counted))


class Search:
    """Looks for the factor of a size at which rms is `wanted`: secants in logarithms, within a bracket once
    there is one.
    """

    def __init__(self, wanted: float) -> None:
        self.wanted = float(np.log(wanted))
        self.at = 0.0  # logarithm of the factor so far
        self.seen: list[tuple[float, float]] = []

    def next(self, rms: float) -> float:
        """Return by what to scale next, for the rms of the present size."""
        self.seen.append((self.at, float(np.log(max(rms, 1e-3)))))
        below = max((s for s in self.seen if s[1] < self.wanted), default=None)
        above = min((s for s in self.seen if s[1] >= self.wanted), default=None)
        if below and above:
            share = (self.wanted - below[1]) / (above[1] - below[1])
            goal = below[0] + min(max(share, 0.2), 0.8) * (above[0] - below[0])
        else:
            goal = self.at + min(max(self.wanted - self.seen[-1][1], -1.8), 1.8) * (
                1.0 + 0.5 * (len(self.seen) > 2)
            )
        step = goal - self.at
        self.at = goal
        return float(np.exp(step))
