"""How much an effect shows: displacements with and without it, in units of their noise."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from benchmarks.displacements import moved
from benchmarks.robot_sets.driving import Array, Drive, Poses, Robot, Setup
from benchmarks.robot_sets.sensing import report

GRID, WINDOW, BETWEEN = 0.1, 2.0, 0.5  # s
LAG = 0.1  # s, of the kinematic robot whose small changes are taken out
CHANGES = (0.01, 0.01, 0.01, 0.02)  # of left gain, right gain, axle (shares) and lag [s]


@dataclass(frozen=True)
class Told:
    """What was reported of one run: displacements (n, 3), and which windows a local effect touched."""

    moves: Array
    touched: Array


@dataclass(frozen=True)
class Seen:
    """The ratios of an effect, and in how many windows of each run it was felt."""

    ratio: float
    position: float
    heading: float
    touched: tuple[int, ...]


def _windows(rows: int) -> tuple[Array, Array]:
    first = np.arange(0, rows - round(WINDOW / GRID), round(BETWEEN / GRID))
    return first, first + round(WINDOW / GRID)


def tell(setup: Setup, drive: Drive, run: int) -> Told:
    """Return what would be reported of a drive without noise."""
    stamps = np.arange(0.0, drive.seconds - 0.05, GRID)
    poses, touched = report(setup, drive, stamps, run)
    first, last = _windows(len(stamps))
    sums = np.concatenate([[0], np.cumsum(touched)])
    return Told(moved(poses, first, last), sums[last + 1] > sums[first])


def _kinematic(robot: Robot, drive: Drive, changes: Array) -> Array:
    """Return the displacements of a first-order kinematic robot as its data sheet has it, with changes."""
    step = 0.01
    rows = round(drive.seconds / step)
    which = np.minimum((np.arange(rows) * step / drive.tick + 1e-9).astype(int), len(drive.commands) - 1)
    keep = math.exp(-step / (LAG + changes[3]))
    full = robot.sheet["max_wheel_rate"] * robot.sheet["wheel_radius"]
    speeds = lfilter([1.0 - keep], [1.0, -keep], drive.commands[which], axis=0) * full
    left, right = speeds[:, 0] * (1.0 + changes[0]), speeds[:, 1] * (1.0 + changes[1])
    yaw = np.cumsum((right - left) * step / (robot.sheet["axle_length"] * (1.0 + changes[2])))
    v = 0.5 * (left + right)
    poses: Poses = (np.cumsum(v * np.cos(yaw)) * step, np.cumsum(v * np.sin(yaw)) * step, yaw)
    every = round(GRID / step)
    count = len(np.arange(0.0, drive.seconds - 0.05, GRID))
    x, y, turned = (p[::every][:count] for p in poses)
    return moved((x, y, turned), *_windows(count))


def basis(robot: Robot, drive: Drive) -> Array:
    """Return what small changes of gains, axle and lag do to the displacements: (n, 3, 4)."""
    plain = _kinematic(robot, drive, np.zeros(4))
    columns = []
    for k, change in enumerate(CHANGES):
        changes = np.zeros(4)
        changes[k] = change
        columns.append(_wrapped(_kinematic(robot, drive, changes) - plain))
    return np.stack(columns, axis=2)


def _wrapped(moves: Array) -> Array:
    moves = moves.copy()
    moves[:, 2] = np.remainder(moves[:, 2] + math.pi, 2.0 * math.pi) - math.pi
    return moves


def compare(
    robot: Robot, one: list[Told], other: list[Told], columns: list[Array], local: bool = False
) -> Seen:
    """Return how much two robots that were told the same differ, over some runs."""
    unit = np.array([robot.sensing.noise_xy, robot.sensing.noise_xy, robot.sensing.noise_theta]) * math.sqrt(
        2.0
    )
    off = np.concatenate([_wrapped(a.moves - b.moves) for a, b in zip(one, other)]) / unit
    design = np.concatenate(columns) / unit[:, None]
    flat = design.reshape(-1, design.shape[2])
    solved = np.linalg.lstsq(flat, off.reshape(-1), rcond=None)[0]
    rest = off - (flat @ solved).reshape(off.shape)
    touched = np.concatenate([a.touched for a in one])
    counts = tuple(int(a.touched.sum()) for a in one)
    if local:
        rest = rest[touched]
    if not len(rest):
        return Seen(1.0, 1.0, 1.0, counts)
    position = math.sqrt(1.0 + float(np.mean(rest[:, :2] ** 2)))
    heading = math.sqrt(1.0 + float(np.mean(rest[:, 2] ** 2)))
    return Seen(max(position, heading), position, heading, counts)
