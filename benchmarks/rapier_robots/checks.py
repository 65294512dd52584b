"""Checks of the simulated physics: prints each figure with its bound.

python benchmarks/rapier_robots/checks.py
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.displacements import moved
from benchmarks.rapier_robots.driver import Driver, start_of
from benchmarks.rapier_robots.engine import GRAVITY, STEP
from benchmarks.rapier_robots.plant import Plant, Robot
from benchmarks.rapier_robots.robots import KINDS, Kind, draw_control, draw_plant, draw_sensing
from benchmarks.rapier_robots.setup import Setup, setup_of
from benchmarks.rapier_robots.simulate import Drive, Simulation, replay
from benchmarks.rapier_robots.sizing import rows


@dataclass(frozen=True)
class Figure:
    """A measured figure and the bound that it must stay within."""

    name: str
    value: float
    bound: float

    @property
    def good(self) -> bool:
        """Whether the figure lies within its bound."""
        return abs(self.value) <= self.bound


def equal_sides(plant: Plant) -> Plant:
    """Return a robot whose left and right are alike, with its mass in the middle plane."""

    def mean(pair: tuple[float, float]) -> tuple[float, float]:
        return (0.5 * (pair[0] + pair[1]),) * 2

    same = {name: mean(getattr(plant, name)) for name in ("radius", "dry", "stall", "free")}
    return replace(plant, com=(plant.com[0], 0.0, plant.com[2]), **same)  # type: ignore[arg-type]


def robot_of(kind: Kind, steered: bool = False) -> Robot:
    """Return an example of a kind."""
    rng = np.random.default_rng([3, KINDS.index(kind)])
    plant = draw_plant(rng, kind, False)
    control = draw_control(rng, kind, plant) if steered else None
    return Robot(kind.name, plant, control, draw_sensing(rng, kind), {}, sum(plant.free) / 2, 1.0, 0.02)


def held(setup: Setup, left: float, right: float, seconds: float, step: float = STEP) -> Drive:
    """Return a drive under constant commands."""
    simulation = Simulation(setup, 0, (0.0, 0.0, 0.0), step)
    return simulation.run(lambda t, x, y, yaw: (left, right), seconds, 0.02)


def equal(kind: Kind) -> Setup:
    """Return a robot of a kind with equal sides that takes duties."""
    robot = robot_of(kind)
    return setup_of(replace(robot, plant=equal_sides(robot.plant)))


def straight() -> list[Figure]:
    """Equal sides drive straight, as far as their wheels roll."""
    aside, way = 0.0, 0.0
    for kind in KINDS:
        setup = equal(kind)
        d = held(setup, 0.6, 0.6, 6.0)
        rolled = setup.plant.radius[0] * float(d.left[-1] - d.left[0])
        aside = max(aside, abs(float(d.y[-1])) / float(d.x[-1]))
        way = max(way, abs(float(d.x[-1]) / rolled - 1.0))
    return [
        Figure("straight with equal sides: aside over ahead, worst of seven kinds", aside, 0.01),
        Figure("straight with equal sides: way over rolled way - 1, worst", way, 0.01),
    ]


def torque_line() -> list[Figure]:
    """A wheel's steady rate is where the motor's torque equals its friction."""
    worst = 0.0
    for kind in KINDS:
        setup = equal(kind)
        p = replace(setup.plant, casters=tuple(replace(c, friction=0.0) for c in setup.plant.casters))
        setup.plant = p
        for share in (0.02, 0.1, 0.2):
            setup.plant = replace(p, dry=(share * p.stall[0],) * 2, rolling=(0.0, 0.0), grip=(1.0, 1.0))
            simulation = Simulation(setup, 0, (0.0, 0.0, 0.0))
            simulation.run(lambda t, x, y, yaw: (0.7 * min(t, 1.0),) * 2, 3.0, 0.02)
            rate = sum(simulation.state.rate) / 2.0
            extra = p.casters[0].roll / p.stall[0] * p.radius[0] / p.casters[0].radius / 2.0
            worst = max(worst, abs(rate / p.free[0] - (0.7 - share - extra)))
    return [Figure("torque-speed line: steady rate off it, over the free rate, 21 loads", worst, 0.01)]


def slope() -> list[Figure]:
    """Dry friction holds a robot on a slope."""
    worst = 0.0
    for kind in KINDS:
        setup = equal(kind)
        p = setup.plant
        need = 2.0 * p.total * GRAVITY * 0.02 * p.radius[0] / 2.0
        setup.plant = replace(p, dry=(need, need), slope=(0.02, 0.0))
        d = held(setup, 0.0, 0.0, 6.0)
        worst = max(worst, float(np.hypot(d.x[-1] - d.x[100], d.y[-1] - d.y[100])))
    return [Figure("rest on a slope of 20 mrad: moved in 5 s [m], worst", worst, 0.001)]


def spin() -> list[Figure]:
    """A robot turns by the difference of its wheels' ways over the axle."""
    worst = 0.0
    for kind in KINDS:
        setup = equal(kind)
        d = held(setup, -0.3, 0.3, 6.0)
        p = setup.plant
        rolled = p.radius[0] * float((d.right[-1] - d.right[0]) - (d.left[-1] - d.left[0])) / p.axle
        worst = max(worst, abs(float(d.yaw[-1] - d.yaw[0]) / rolled - 1.0))
    return [Figure("spin: turned over the wheels' ways by the axle - 1, worst", worst, 0.01)]


def slippery() -> list[Figure]:
    """On a slippery floor no robot speeds up faster than its grip lets it."""
    worst, grip = 0.0, 0.04
    for kind in KINDS:
        setup = equal(kind)
        first, *others = setup.plant.casters
        smooth = tuple(replace(c, kind="ball", friction=0.0) for c in (first, *others))
        setup.plant = replace(setup.plant, grip=(grip, grip), casters=smooth)
        d = held(setup, 1.0, 1.0, 0.5)
        speed = float(d.x[45] - d.x[44]) / 0.01
        worst = max(worst, speed / 0.445 / (grip * GRAVITY))
    return [Figure("speeding up on a floor of friction 0.04, over mu g: largest", worst, 1.02)]


def halved() -> list[Figure]:
    """A halved step and the same run again."""
    figures = []
    for steered in (False, True):
        worst, same = 0.0, 0.0
        for kind in KINDS:
            robot = robot_of(kind, steered)
            rng = np.random.default_rng(5)
            start = start_of(rng, 1.0)
            setup = setup_of(robot)
            d = Simulation(setup, 0, start).run(Driver(rng, 1.0, 0.02, 0.0), 20.0, 0.02)
            again = Simulation(setup, 0, start).run(replay(d.commands, 0.02), 20.0, 0.02)
            fine = Simulation(setup, 0, start, STEP / 2).run(replay(d.commands, 0.02), 20.0, 0.02)
            same = max(same, float(np.abs(again.x - d.x).max()), float(np.abs(again.yaw - d.yaw).max()))
            worst = max(worst, _apart(d, fine))
        name = "speed" if steered else "duty"
        figures.append(Figure(f"step halved, {name}: rms of displacements over 2 s [m], worst", worst, 0.003))
        figures.append(Figure(f"the same run twice, {name}: largest difference", same, 0.0))
    return figures


def _apart(one: Drive, two: Drive) -> float:
    first, last = rows(len(one.x[::10]))
    a, b = (moved((d.x[::10], d.y[::10], d.yaw[::10]), first, last) for d in (one, two))
    return math.sqrt(float(((a - b)[:, :2] ** 2).sum(axis=1).mean()))


def main() -> None:
    """Print every figure; the exit status tells whether all lie within their bounds."""
    good = True
    for check in (straight, torque_line, slope, spin, slippery, halved):
        for figure in check():
            good = good and figure.good
            mark = "" if figure.good else "  OUT OF BOUNDS"
            print(f"{figure.name:76s}{figure.value:12.3g}{figure.bound:10.3g}{mark}", flush=True)
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
