"""How visible an effect is: what four numbers of a kinematic robot cannot take up, over the noise."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from benchmarks.displacements import moved
from benchmarks.rapier_robots.plant import Robot
from benchmarks.rapier_robots.sensing import report
from benchmarks.rapier_robots.setup import Array, Poses, Setup
from benchmarks.rapier_robots.simulate import EVERY, Drive

GRID, WINDOW, EVERY_ROW = 0.1, 20, 5  # s; rows of a window; rows between windows


@dataclass(frozen=True)
class Seen:
    """Visibility: `ratio` is the larger of position and heading; `touched`: windows that count, for each run."""

    position: float
    heading: float
    touched: tuple[int, ...]

    @property
    def ratio(self) -> float:
        """The larger one."""
        return max(self.position, self.heading)


@dataclass(frozen=True)
class Told:
    """One drive as a robot tells it: displacements over 2 s without noise, and which windows an effect touches."""

    moves: Array
    touched: Array


def grid(seconds: float) -> Array:
    """Return the stamps at which drives are compared [s]."""
    return np.asarray(np.arange(0.0, seconds - 0.05, GRID))


def rows(count: int) -> tuple[Array, Array]:
    """Return first and last rows of the windows."""
    first = np.arange(0, count - WINDOW, EVERY_ROW)
    return first, first + WINDOW


def tell(setup: Setup, drive: Drive, run: int) -> Told:
    """Return a drive as it is reported."""
    poses, touched = report(setup, drive, grid(drive.seconds), run)
    first, last = rows(len(poses[0]))
    hit = np.array([bool(touched[a : b + 1].any()) for a, b in zip(first, last)])
    return Told(moved(poses, first, last), hit)


def _kinematic(commands: Array, tick: float, left: float, right: float, axle: float, tau: float) -> Poses:
    """Return poses of a first-order kinematic robot every 0.1 s; gains in m/s."""
    held = np.repeat(commands, round(tick / EVERY), axis=0)
    share = 1.0 - math.exp(-EVERY / tau)
    speeds = np.empty_like(held)
    a = b = 0.0
    for n, (u, v) in enumerate((held * [left, right]).tolist()):
        a += share * (u - a)
        b += share * (v - b)
        speeds[n] = a, b
    ahead, turn = speeds.mean(axis=1), (speeds[:, 1] - speeds[:, 0]) / axle
    yaw = np.concatenate([[0.0], np.cumsum(turn) * EVERY])
    middle = yaw[:-1] + 0.5 * turn * EVERY
    x = np.concatenate([[0.0], np.cumsum(ahead * np.cos(middle)) * EVERY])
    y = np.concatenate([[0.0], np.cumsum(ahead * np.sin(middle)) * EVERY])
    step = round(GRID / EVERY)
    return x[::step], y[::step], yaw[::step]


def basis(robot: Robot, drive: Drive) -> Array:
    """Return how displacements (n, 3, 4) change with left gain, right gain, axle and time constant."""
    sheet = robot.sheet
    gain = sheet["wheel_radius"] * sheet["max_wheel_rate"]
    plain = (gain, gain, sheet["axle_length"], 0.1)
    count = len(grid(drive.seconds))
    first, last = rows(count)

    def moves(values: tuple[float, ...]) -> Array:
        poses = _kinematic(drive.commands, drive.tick, *values)
        x, y, yaw = (p[:count] for p in poses)
        return moved((x, y, yaw), first, last)

    zero, columns = moves(plain), []
    for n in range(4):
        other = list(plain)
        other[n] *= 1.01
        diff = (moves(tuple(other)) - zero) / 0.01
        diff[:, 2] = np.remainder(diff[:, 2] * 0.01 + math.pi, 2 * math.pi) / 0.01 - math.pi / 0.01
        columns.append(diff)
    return np.stack(columns, axis=2)


def compare(
    robot: Robot, with_it: list[Told], without: list[Told], bases: list[Array], local: bool = False
) -> Seen:
    """Return how visible the difference of drives is; `local`: only touched windows count."""
    unit = math.sqrt(2.0) * np.array([robot.sensing.noise_xy] * 2 + [robot.sensing.noise_theta])
    diffs = []
    for a, b in zip(with_it, without):
        diff = a.moves - b.moves
        diff[:, 2] = np.remainder(diff[:, 2] + math.pi, 2 * math.pi) - math.pi
        diffs.append(diff / unit)
    off = np.concatenate(diffs)
    columns = np.concatenate(bases) / unit[:, None]
    best = np.linalg.lstsq(columns.reshape(-1, 4), off.reshape(-1), rcond=None)[0]
    rest = off - columns @ best
    hits = [a.touched | b.touched for a, b in zip(with_it, without)]
    if local:
        rest = rest[np.concatenate(hits)]
    if not len(rest):
        return Seen(1.0, 1.0, tuple(int(h.sum()) for h in hits))
    square = np.mean(rest**2, axis=0)
    return Seen(
        math.sqrt(1.0 + float(square[:2].mean())),
        math.sqrt(1.0 + float(square[2])),
        tuple(int(h.sum()) for h in hits),
    )
