"""Drive a robot for a while and keep the truth of it; what the engines' robots have in common."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

EVERY = 0.01  # s between kept rows
FAR = 6.0  # areas from the middle at which a run is given up
Array = NDArray[Any]
Poses = tuple[Array, Array, Array]
Place = tuple[float, float, float]
Teller = Callable[[Place], tuple[float, float]]


@dataclass(frozen=True)
class Sensing:
    """How poses and wheel angles are taken: poses a second, noise [m] and [rad], shares of missing poses and of outliers,
    how many gaps, the tag [m, rad], ticks a turn.
    """

    rate: float
    noise_xy: float
    noise_theta: float
    missing: float
    tail: float
    gaps: int
    tag: tuple[float, float]
    tag_yaw: float
    encoder_ticks: int


class Robot(Protocol):
    """A robot with its cameras and data sheet; area [m], tick [s] of its commands."""

    sensing: Sensing
    area: float
    tick: float
    sheet: dict[str, float]


class Setup(Protocol):
    """A robot with what laws do to how it is seen."""

    robot: Any
    sensing: Sensing
    clocks: list[Any]
    filters: list[Any]
    tags: list[Any]
    markers: list[Any]


class Machine(Protocol):
    """A robot under way: `now` has its pose, the time and whether a local law touches it."""

    now: Any

    @property
    def motors(self) -> tuple[float, float]:
        """How far the motors have turned [rad]."""

    @property
    def has_fallen(self) -> bool:
        """Whether the robot lies on its side."""

    def advance(self, told: tuple[float, float]) -> None:
        """Make one step under a command."""


class RanOff(Exception):
    """The robot fell over, flew or left."""


@dataclass(frozen=True)
class Drive:
    """The truth of a run every `EVERY` s: the axle's middle, the motors' angles, where local laws touched."""

    time: Array
    x: Array
    y: Array
    yaw: Array
    left: Array
    right: Array
    touched: NDArray[np.bool_]
    commands: Array
    tick: float
    seconds: float


def replay(commands: Array, tick: float) -> Teller:
    """Return a teller of recorded commands."""
    rows = iter([(float(a), float(b)) for a, b in commands])

    def told(_: Place) -> tuple[float, float]:
        return next(rows, (0.0, 0.0))

    return told


def driven(machine: Machine, robot: Robot, tell: Teller, seconds: float, step: float) -> Drive:
    """Return the drive of a machine by steps of `step` [s]; `tell` is asked for the wheels' commands at every tick."""
    now, tick = machine.now, robot.tick
    per_tick, per_row = round(tick / step), round(EVERY / step)
    limit = FAR * robot.area
    rows: list[tuple[float, float, float, float, float, bool]] = []
    commands: list[tuple[float, float]] = []
    told, touched = (0.0, 0.0), False
    for count in range(round(seconds / step)):
        if count % per_tick == 0:
            told = tell((now.x, now.y, now.yaw))
            commands.append(told)
        if count % per_row == 0:
            rows.append((now.x, now.y, now.yaw, *machine.motors, touched))
            touched = False
            if not math.hypot(now.x, now.y) < limit or machine.has_fallen:
                raise RanOff(f"at {now.t:.1f} s")
        now.touched = False
        machine.advance(told)
        touched = touched or now.touched
    rows.append((now.x, now.y, now.yaw, *machine.motors, touched))
    kept = np.array([row[:5] for row in rows])
    x, y, yaw, left, right = (np.ascontiguousarray(kept[:, k]) for k in range(5))
    time, marks = np.arange(len(rows)) * EVERY, np.array([row[5] for row in rows])
    return Drive(time, x, y, yaw, left, right, marks, np.array(commands), tick, seconds)
