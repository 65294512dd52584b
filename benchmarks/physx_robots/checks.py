"""Figures with bounds that show what the simulation is worth: python benchmarks/physx_robots/checks.py (a minute)."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np

from benchmarks.physx_robots.case import Bench
from benchmarks.physx_robots.departures import data_sheet
from benchmarks.physx_robots.engine import STEP
from benchmarks.physx_robots.kinds import KINDS
from benchmarks.physx_robots.robots import GRAVITY, Robot, change_motors, draw_robot
from benchmarks.physx_robots.simulate import Drive, Simulation, replay
from benchmarks.physx_robots.sizing import on_grid, windows_of

CONTACTS = ("engine", "brush")


@dataclass(frozen=True)
class Figure:
    """A measured figure and the bound that it must not pass."""

    what: str
    value: float
    bound: float

    def __str__(self) -> str:
        """Return a row of the table."""
        return f"{self.what:66s}{self.value:12.3g}{self.bound:12.3g}  {'ok' if self.value <= self.bound else 'FAILS'}"


def kind_of(name: str, tyre: str, drive: str = "duty") -> Robot:
    """Return a robot of a kind without departures."""
    for seed in range(1000):
        robot = draw_robot(np.random.default_rng([41, seed]), {"tyre": tyre, "drive": drive})
        if robot.kind == name:
            return robot
    raise ValueError(name)


def steady(robot: Robot, left: float, right: float, seconds: float = 4.0, step: float = STEP) -> Drive:
    """Drive with constant commands."""
    return Simulation(robot, [], step).run(lambda t, pose: (left, right), seconds)


def straight_and_spin() -> Iterator[Figure]:
    """Yield how straight alike wheels drive, and how well the axle's length holds."""
    for tyre in CONTACTS:
        aside, turned, axles = [], [], []
        for name in KINDS:
            robot = kind_of(name, tyre)
            drive = steady(robot, 0.6, 0.6)
            aside.append(abs(drive.y[-1]) / drive.x[-1])
            rolled = float(drive.angle[-1].mean()) * robot.radius
            turned.append(abs(drive.x[-1] / rolled - 1.0))
            level = min(0.6, 1.5 * robot.axle / robot.speed)
            spin = steady(robot, -level, level)
            part = slice(len(spin.time) // 2, None)
            angle = np.ptp(spin.angle[part, 1] - spin.angle[part, 0])
            axles.append(abs(np.ptp(spin.yaw[part]) * robot.axle / (angle * robot.radius) - 1.0))
        yield Figure(f"straight drive, {tyre}: aside over ahead, worst kind", max(aside), 0.01)
        yield Figure(f"straight drive, {tyre}: way over rolled way - 1, worst kind", max(turned), 0.01)
        yield Figure(f"spin, {tyre}: turned over rolled by the axle - 1, worst kind", max(axles), 0.01)


def torque_speed_line() -> Iterator[Figure]:
    """Yield the distance from the torque-speed line, over the motor's free speed."""
    worst = 0.0
    for name in KINDS:
        robot = kind_of(name, "engine")
        motor, wheel = robot.motors[0], robot.wheels[0]
        drag = sum(robot.rolling * load * wheel.radius for load in robot.loads) / 2 + motor.coulomb
        on_caster = robot.total_mass * GRAVITY - sum(robot.loads)
        if robot.casters[0].kind != "swivel":
            drag += 0.5 * robot.casters[0].friction * on_caster * wheel.radius
        for duty in (0.3, 0.6, 1.0, -0.6):
            drive = steady(robot, duty, duty, 4.0)
            rate = np.polyfit(drive.time[-100:], drive.angle[-100:].mean(axis=1), 1)[0]
            line = motor.free * (duty - np.sign(duty) * drag / motor.stall)
            worst = max(worst, abs(rate - line) / motor.free)
    yield Figure("steady rate from the torque-speed line, over the free speed", worst, 0.01)


def friction_limits() -> Iterator[Figure]:
    """Yield what slippery floors, slopes and coasting must keep to."""
    for tyre in CONTACTS:
        robot = kind_of("kobuki", tyre)
        grip = 0.05
        slick = replace(robot, tyre=replace(robot.tyre, grip=grip, side_grip=grip))
        drive = steady(slick, 1.0, 1.0, 1.0)
        speed = np.gradient(drive.x, drive.time)
        gained = float(speed[60] - speed[20]) / 0.4
        most = grip * sum(robot.loads) / robot.total_mass
        yield Figure(f"speeding up at grip 0.05, {tyre}: over what the load allows", gained / most, 1.02)
        sloped = replace(
            change_motors(robot, lambda m: replace(m, coulomb=0.1 * m.stall)), tilt=(0.01, 0.005)
        )
        rest = steady(sloped, 0.0, 0.0, 6.0)
        moved = np.hypot(rest.x[-1] - rest.x[100], rest.y[-1] - rest.y[100])
        yield Figure(f"standing on a slope for 5 s, {tyre}: moved [m]", float(moved), 0.001)
        free = change_motors(robot, lambda m: replace(m, brake=0.0))
        coast = Simulation(free, []).run(lambda t, pose: (0.8, 0.5) if t < 2.0 else (0.0, 0.0), 6.0)
        squared = np.gradient(coast.x, coast.time) ** 2 + np.gradient(coast.y, coast.time) ** 2
        growth = np.diff(squared[230::20])
        yield Figure(
            f"coasting, {tyre}: growth of v^2 in 0.2 s over its start",
            float(growth.max() / squared[200]),
            0.005,
        )


def numbers() -> Iterator[Figure]:
    """Yield what the step's length and a second run change."""
    for tyre in CONTACTS:
        for drive_by in ("duty", "speed"):
            rng = np.random.default_rng([43, len(tyre), len(drive_by)])
            robot, _ = data_sheet(rng, kind_of("kobuki", tyre, drive_by))
            bench = Bench(robot, (1, 2, 3), rng)
            bench.durations = [20.0] * 3
            told = bench.drive([], 0)
            fine = Simulation(robot, [], STEP / 2).run(replay(told.command_time, told.command), 20.0)
            worst = _two_seconds_apart(told, fine)
            yield Figure(f"step halved, {tyre}, {drive_by}: rms of displacements over 2 s [m]", worst, 0.002)
            again = bench.drive([], 0)
            same = np.array_equal(told.x, again.x) and np.array_equal(told.command, again.command)
            yield Figure(f"the same run twice, {tyre}, {drive_by}: unequal (0 or 1)", float(not same), 0.0)


def _two_seconds_apart(one: Drive, other: Drive) -> float:
    grids = [on_grid({"stamp": d.time, "x": d.x, "y": d.y, "yaw": d.yaw}, 20.0) for d in (one, other)]
    differ = windows_of(grids[0]) - windows_of(grids[1])
    return float(np.sqrt(np.mean(differ[:, :2] ** 2)))


CHECKS: tuple[Callable[[], Iterator[Figure]], ...] = (
    straight_and_spin,
    torque_speed_line,
    friction_limits,
    numbers,
)


def main() -> None:
    """Print all figures; the exit code says whether all keep their bounds."""
    print(f"{'figure':66s}{'measured':>12s}{'bound':>12s}")
    failed = 0
    for check in CHECKS:
        for figure in check():
            print(figure, flush=True)
            failed += figure.value > figure.bound
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
