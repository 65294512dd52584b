"""Show that robots of the Open Dynamics Engine do what the equations say.

python benchmarks/ode_robots/checks.py
"""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.displacements import moved
from benchmarks.ode_robots.engine import STEP
from benchmarks.ode_robots.machine import Machine, Now
from benchmarks.ode_robots.plant import Robot
from benchmarks.ode_robots.robots import KINDS, draw_robot
from benchmarks.ode_robots.setup import Hook, Setup, setup_of
from benchmarks.ode_robots.simulate import simulate
from benchmarks.robot_sets.driver import Driver, start_of
from benchmarks.robot_sets.driving import Drive, Poses, replay

START = (0.1, -0.2, 0.7)


def of_kind(name: str, number: int = 0, needs: tuple[str, ...] = ("duty",)) -> Robot:
    """Return the first robot of a kind."""
    for k in range(200):
        robot = draw_robot(np.random.default_rng([77, number, k]), frozenset(needs), False)
        if robot.kind == name:
            return robot
    raise ValueError(name)


def even(robot: Robot) -> Robot:
    """Return a robot whose sides are alike and whose mass lies in its middle line."""
    p = robot.plant
    same = replace(
        p,
        radius=(p.radius[0],) * 2,
        stall=(p.stall[0],) * 2,
        free=(p.free[0],) * 2,
        dry=(p.dry[0],) * 2,
        centre=(p.centre[0], 0.0, p.centre[2]),
    )
    return replace(robot, plant=same)


def driven(setup: Setup, left: float, right: float, seconds: float, step: float = STEP) -> Drive:
    """Return a drive under one command."""
    return simulate(setup, lambda pose: (left, right), seconds, 0, START, step)


def straight(robot: Robot) -> tuple[float, float]:
    """Return how far an even robot leaves its line [m per m] and how far it turns [rad per m]."""
    drive = driven(setup_of(even(robot)), 0.6, 0.6, 4.0)
    dx, dy = drive.x[-1] - drive.x[0], drive.y[-1] - drive.y[0]
    way = math.hypot(dx, dy)
    aside = -dx * math.sin(START[2]) + dy * math.cos(START[2])
    return abs(aside) / way, abs(drive.yaw[-1] - START[2]) / way


def torque_line(robot: Robot) -> float:
    """Return by what share of the free rate the final rate differs from the torque-speed line less its friction."""
    p = robot.plant
    machine = Machine(setup_of(robot), 0, START)
    for _ in range(round(4.0 / STEP)):
        machine.advance((0.7, 0.7))
    off = []
    for side in (0, 1):
        torque = p.dry[side] + p.rolling * machine.load * p.radius[side]
        line = p.free[side] * (0.7 - torque / p.stall[side])
        drag = 0.02 * p.free[side]  # a caster's and the tyre's share, unknown here
        off.append((machine.now.rate[side] - line) / p.free[side])
        if not -drag < machine.now.rate[side] - line < drag:
            off[-1] = math.inf
    return max(off, key=abs)


def on_slope(robot: Robot, tilt: float) -> float:
    """Return how far a robot with idle motors creeps in 5 s on a slope that its dry friction holds [m]."""

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            now.slope = (tilt * math.cos(START[2]), tilt * math.sin(START[2]))

        return hook

    setup = setup_of(robot)
    setup.floor.append(make)
    drive = driven(setup, 0.0, 0.0, 6.0)
    return math.hypot(drive.x[-1] - drive.x[100], drive.y[-1] - drive.y[100])


def held_tilt(robot: Robot) -> float:
    """Return the slope that dry friction alone should hold [rad]."""
    p = robot.plant
    hold = sum(d / r + 0.4 * p.rolling * p.mass * 9.81 for d, r in zip(p.dry, p.radius))
    return math.asin(0.5 * hold / (p.mass * 9.81))


def spin(robot: Robot) -> float:
    """Return the turn of a spin over what the wheels' angles say."""
    drive = driven(setup_of(robot), -0.4, 0.4, 4.0)
    r = robot.plant.radius
    said = (drive.right[-1] * r[1] - drive.left[-1] * r[0]) / robot.plant.axle
    return float((drive.yaw[-1] - drive.yaw[0]) / said)


def windows(one: Drive, other: Drive) -> tuple[float, float]:
    """Return root mean squares of differences of displacements over 2 s [m, rad]."""
    first = np.arange(0, len(one.time) - 201, 50)

    def poses(drive: Drive) -> Poses:
        return drive.x, drive.y, drive.yaw

    off = moved(poses(one), first, first + 200) - moved(poses(other), first, first + 200)
    turn = np.remainder(off[:, 2] + math.pi, 2.0 * math.pi) - math.pi
    return float(np.sqrt(np.mean(off[:, 0] ** 2 + off[:, 1] ** 2))), float(np.sqrt(np.mean(turn**2)))


def main() -> None:
    """Print the table of checks."""
    print(
        "kind      feet  aside mm/m  turn mrad/m  line %  slope mm in 5 s  spin ratio  half step mm  mrad  again"
    )
    for name in sorted(KINDS):
        robot = of_kind(name)
        rng = np.random.default_rng(5)
        driver = Driver(rng, robot.area, robot.tick, 0.002)
        start = start_of(rng, robot.area)
        drive = simulate(setup_of(robot), driver, 20.0, 0, start)
        again = simulate(setup_of(robot), replay(drive.commands, drive.tick), 20.0, 0, start)
        fine = simulate(setup_of(robot), replay(drive.commands, drive.tick), 20.0, 0, start, STEP / 2)
        same = np.array_equal(drive.x, again.x) and np.array_equal(drive.yaw, again.yaw)
        aside, turn = straight(robot)
        xy, yaw = windows(drive, fine)
        print(
            f"{name:9s} {robot.plant.feet[0].kind:5s} {1e3 * aside:9.2f} {1e3 * turn:12.2f}"
            f" {100 * torque_line(robot):8.2f} {1e3 * on_slope(robot, held_tilt(robot)):12.3f}"
            f" {spin(robot):15.4f} {1e3 * xy:10.2f} {1e3 * yaw:8.2f}  {'equal' if same else 'UNLIKE'}",
            flush=True,
        )


if __name__ == "__main__":
    main()
