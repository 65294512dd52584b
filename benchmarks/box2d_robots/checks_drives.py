"""Robots and drives on which laws are checked."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from benchmarks.box2d_robots.machine import STEP, Machine
from benchmarks.box2d_robots.parts import Pair, Robot, Setup, setup_of
from benchmarks.box2d_robots.robots import draw_robot
from benchmarks.box2d_robots.simulate import simulate
from benchmarks.robot_sets.driving import Drive
from benchmarks.robot_sets.laws import Draw, Law

Found = tuple[float, float, bool]
Check = Callable[[Law], Found]
SPOTS = ((0.0, 0.0), (0.2, 0.2))
DRAW = Draw((0.3, 0.6, 0.4, 0.7, 0.2, 0.5), 11, SPOTS, 55.0, 1.0)
ORIGIN = (0.0, 0.0, 0.0)


def of_kind(name: str, needs: tuple[str, ...] = ("duty",)) -> Robot:
    """Return the first robot of a kind."""
    for k in range(300):
        robot = draw_robot(np.random.default_rng([77, k]), frozenset(needs), False)
        if robot.kind == name:
            return robot
    raise ValueError(name)


def even(robot: Robot) -> Robot:
    """Return a robot whose sides are alike and whose mass lies in its middle line."""
    p = robot.plant
    names = ("radius", "torque_const", "emf_const", "winding", "dry")
    same = {name: (getattr(p, name)[0],) * 2 for name in names}
    return replace(robot.changed(**same, centre=(p.centre[0], 0.0, p.centre[2])), reverse=0.0)


def driven(
    setup: Setup, left: float, right: float, seconds: float, start: tuple[float, float, float] = ORIGIN
) -> Drive:
    """Return a drive under one command."""
    return simulate(setup, lambda pose: (left, right), seconds, 0, start)


def both(law: Law, size: float | None = None) -> tuple[Setup, Setup]:
    """Return an even robot without and with a law of middle size."""
    robot = even(of_kind("vacuum", (*law.needs, "duty")))
    plain, other = setup_of(robot), setup_of(robot)
    law.apply(other, size or math.sqrt(law.low * law.high), DRAW)
    return plain, other


def speed(drive: Drive, at: float) -> float:
    """Return the forward speed over the second before `at` [m/s]."""
    last = round(at / 0.01)
    first = last - 100
    dx, dy, yaw = (
        drive.x[last] - drive.x[first],
        drive.y[last] - drive.y[first],
        drive.yaw[(first + last) // 2],
    )
    return float(dx * math.cos(yaw) + dy * math.sin(yaw))


def compared(law: Law, quantity: Callable[[Setup], float], good: Callable[[float, float], bool]) -> Found:
    plain, other = both(law)
    a, b = quantity(plain), quantity(other)
    return a, b, good(a, b)


def steps(
    setup: Setup, told: Callable[[float], Pair], seconds: float, see: Callable[[Machine], float]
) -> np.ndarray:
    """Return what is seen of a machine in each step."""
    machine = Machine(setup, 0, ORIGIN)
    seen = []
    for n in range(round(seconds / STEP)):
        machine.advance(told(n * STEP))
        seen.append(see(machine))
    return np.array(seen)


def winding() -> Callable[[tuple[float, float, float]], Pair]:
    """Return a teller of a winding drive, to and fro."""
    count = [0]

    def told(pose: tuple[float, float, float]) -> Pair:
        count[0] += 1
        v, w = (0.6, 0.0) if count[0] % 60 < 25 else ((-0.5, 0.1) if count[0] % 60 < 45 else (0.2, 0.3))
        return v - w, v + w

    return told


def slower(left: float, right: float, at: float = 4.0, start: tuple[float, float, float] = ORIGIN) -> Check:
    """Return a check that a law makes the robot slower under one command."""

    def check(law: Law) -> Found:
        return compared(
            law, lambda s: speed(driven(s, left, right, at, start), at), lambda a, b: b < 0.99 * a
        )

    return check


def turns_less(law: Law) -> Found:
    """Check that a law makes the robot turn less on the spot."""
    return compared(law, lambda s: float(driven(s, -0.4, 0.4, 3.0).yaw[-1]), lambda a, b: b < 0.999 * a)
