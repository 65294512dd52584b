"""Drive a robot for a while and keep the truth of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.ode_robots.engine import STEP
from benchmarks.ode_robots.machine import Machine
from benchmarks.ode_robots.setup import Array, Setup

EVERY = 0.01  # s between kept rows
FAR = 6.0  # areas from the middle at which a run is given up
Teller = Callable[[tuple[float, float, float]], tuple[float, float]]


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

    def told(_: tuple[float, float, float]) -> tuple[float, float]:
        return next(rows, (0.0, 0.0))

    return told


def simulate(
    setup: Setup,
    tell: Teller,
    seconds: float,
    run: int,
    start: tuple[float, float, float],
    step: float = STEP,
) -> Drive:
    """Return a drive from `start`; `tell` is asked for the wheels' commands at every tick."""
    machine = Machine(setup, run, start, step)
    now, tick = machine.now, setup.robot.tick
    per_tick, per_row = round(tick / step), round(EVERY / step)
    limit = FAR * setup.robot.area
    rows: list[tuple[float, float, float, float, float, bool]] = []
    commands: list[tuple[float, float]] = []
    told, touched = (0.0, 0.0), False
    for count in range(round(seconds / step)):
        if count % per_tick == 0:
            told = tell((now.x, now.y, now.yaw))
            commands.append(told)
        if count % per_row == 0:
            rows.append((now.x, now.y, now.yaw, now.angle[0], now.angle[1], touched))
            touched = False
            if not math.hypot(now.x, now.y) < limit or abs(machine.axis[2]) > 0.4:
                raise RanOff(f"at {now.t:.1f} s")
        now.touched = False
        machine.advance(told)
        touched = touched or now.touched
    rows.append((now.x, now.y, now.yaw, now.angle[0], now.angle[1], touched))
    kept = np.array([row[:5] for row in rows])
    x, y, yaw, left, right = (np.ascontiguousarray(kept[:, k]) for k in range(5))
    time, marks = np.arange(len(rows)) * EVERY, np.array([row[5] for row in rows])
    return Drive(time, x, y, yaw, left, right, marks, np.array(commands), tick, seconds)
