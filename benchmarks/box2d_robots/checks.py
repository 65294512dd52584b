"""Show that robots in Box2D do what the equations say, and that each law alone does what its label says.

python benchmarks/box2d_robots/checks.py [--only LABEL,LABEL]
"""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.box2d_robots import generate  # it loads the laws
from benchmarks.box2d_robots.checks_drives import driven, even, of_kind
from benchmarks.box2d_robots.checks_laws import CHECKS
from benchmarks.box2d_robots.machine import STEP, Machine
from benchmarks.box2d_robots.parts import Robot, setup_of
from benchmarks.box2d_robots.robots import KINDS
from benchmarks.box2d_robots.simulate import simulate
from benchmarks.displacements import moved
from benchmarks.robot_sets.driver import Driver, start_of
from benchmarks.robot_sets.driving import Drive, replay
from benchmarks.robot_sets.laws import OUTSIDE

assert generate.MODULES


def windows(one: Drive, other: Drive) -> tuple[float, float]:
    """Return root mean squares of differences of displacements over 2 s [m, rad]."""
    first = np.arange(0, len(one.time) - 201, 50)
    moves = [moved((d.x, d.y, d.yaw), first, first + 200) for d in (one, other)]
    off = moves[0] - moves[1]
    turn = np.remainder(off[:, 2] + math.pi, 2.0 * math.pi) - math.pi
    return float(np.sqrt(np.mean(off[:, 0] ** 2 + off[:, 1] ** 2))), float(np.sqrt(np.mean(turn**2)))


def straight(robot: Robot) -> tuple[float, float]:
    """Return how far an even robot leaves its line [m per m] and turns [rad per m]."""
    drive = driven(setup_of(even(robot)), 0.6, 0.6, 4.0)
    return abs(drive.y[-1]) / drive.x[-1], abs(drive.yaw[-1]) / drive.x[-1]


def line(robot: Robot) -> float:
    """Return by what share of the free rate an even robot without third-point drag misses the torque-speed
    line.
    """
    p = even(robot).plant
    bare = replace(p, third=replace(p.third, slide=0.0, roll=0.0, swivel=0.0))
    machine = Machine(setup_of(replace(even(robot), plant=bare)), 0, (0.0, 0.0, 0.0))
    for _ in range(round(5.0 / STEP)):
        machine.advance((0.7, 0.7))
    now = machine.now
    torque = p.dry[0] + p.rolling * float(now.load[0]) * p.radius[0]
    said = p.free() * (0.7 - torque / p.stall())
    return (float(now.rate[0]) - said) / p.free()


def coasting(robot: Robot) -> float:
    """Return the energy lost while the bridges are open over the work of dry friction and rolling (1 is
    right).
    """
    p = even(robot).plant
    bare = replace(p, third=replace(p.third, slide=0.0, roll=0.0, swivel=0.0))
    machine = Machine(setup_of(replace(even(robot), plant=bare)), 0, (0.0, 0.0, 0.0))
    for _ in range(round(2.0 / STEP)):
        machine.advance((0.7, 0.7))
    machine.nominal[machine.nominal == p.winding[0]] = 1e9  # the windings are cut
    for _ in range(round(0.05 / STEP)):
        machine.advance((0.0, 0.0))

    def energy() -> float:
        v, rate = float(machine.now.motion[0]), float(machine.now.rate[0])
        return 0.5 * p.mass * v * v + (p.wheel_inertia + p.rotor_inertia) * rate**2

    begin, angle, work = energy(), machine.now.angle.copy(), 0.0
    for _ in range(round(0.2 / STEP)):
        held = p.dry[0] + p.rolling * float(machine.now.load[0]) * p.radius[0]
        machine.advance((0.0, 0.0))
        work += 2.0 * held * float(machine.now.angle[0] - angle[0])
        angle = machine.now.angle.copy()
    return (begin - energy()) / work


def spin(robot: Robot) -> float:
    """Return the turn of a spin over what the wheels' angles say."""
    drive, p = driven(setup_of(robot), -0.4, 0.4, 4.0), robot.plant
    return float(drive.yaw[-1] / ((drive.right[-1] * p.radius[1] - drive.left[-1] * p.radius[0]) / p.axle))


def loads(robot: Robot) -> float:
    """Return the loads of all contacts over the weight, while the robot speeds up on a curve."""
    machine = Machine(setup_of(robot), 0, (0.0, 0.0, 0.0))
    for _ in range(60):
        machine.advance((0.4, 0.9))
    third = machine.state[35] + machine.state[36]
    return float((machine.now.load.sum() + third) / (robot.plant.mass * 9.81))


def plant_table() -> None:
    """Print what robots without laws do."""
    print(
        "kind     third   aside mm/m  turn mrad/m  line %  coast  spin    loads   half step mm  mrad  again"
    )
    for name in KINDS:
        robot, rng = of_kind(name), np.random.default_rng(5)
        driver, start = Driver(rng, robot.area, robot.tick, 0.002), start_of(rng, robot.area)
        drive = simulate(setup_of(robot), driver, 20.0, 0, start)
        again = simulate(setup_of(robot), replay(drive.commands, drive.tick), 20.0, 0, start)
        fine = simulate(setup_of(robot), replay(drive.commands, drive.tick), 20.0, 0, start, STEP / 2)
        same = np.array_equal(drive.x, again.x) and np.array_equal(drive.yaw, again.yaw)
        (aside, turn), (xy, yaw) = straight(robot), windows(drive, fine)
        print(
            f"{name:8s} {robot.plant.third.kind:7s} {1e3 * aside:9.2f} {1e3 * turn:12.2f}"
            f" {100 * line(robot):8.2f}"
            f" {coasting(robot):7.3f} {spin(robot):7.4f} {loads(robot):7.4f}"
            f" {1e3 * xy:10.3f} {1e3 * yaw:9.3f}"
            f"  {'equal' if same else 'UNLIKE'}",
            flush=True,
        )


def law_table(labels: list[str]) -> int:
    """Print what each law does to the quantity of its label; return how many do something else."""
    wrong = 0
    print("label                    law                     without     with      size")
    for label in labels:
        for law in generate.SET.laws_of(label):
            without, with_it, good = CHECKS[label](law)
            wrong += not good
            size = math.sqrt(law.low * law.high)
            print(
                f"{label:24s} {law.name:22s} {without:9.4f} {with_it:9.4f} {size:9.4f}"
                f"  {'' if good else 'WRONG'}",
                flush=True,
            )
    return wrong


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", default="", help="labels, with commas; without the table of the plant")
    args = parser.parse_args()
    if not args.only:
        plant_table()
    wrong = law_table([name for name in args.only.split(",") if name] or [*generate.SET.labels, OUTSIDE])
    print(f"{wrong} laws do something else than their label says")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
