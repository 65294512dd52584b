"""Simulate robots with hidden effects in the Open Dynamics Engine; write their recordings and a key.

python benchmarks/ode_robots/generate.py --seed 1 --robots 12 --out DIR [--only 0,3] [--verbose]
"""

from __future__ import annotations

import signal
import sys
from dataclasses import replace
from functools import partial
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.ode_robots import (
    laws_body,
    laws_command,
    laws_floor,
    laws_lag,
    laws_motor,
    laws_outside,
    laws_push,
    laws_sensing,
    laws_supply,
)
from benchmarks.ode_robots.laws import GROUPS, TABLE
from benchmarks.ode_robots.plant import Robot
from benchmarks.ode_robots.robots import NUISANCES, described, draw_robot, without
from benchmarks.ode_robots.setup import Setup, setup_of
from benchmarks.ode_robots.simulate import simulate
from benchmarks.robot_sets.command_line import main
from benchmarks.robot_sets.robot_set import RobotSet, robot
from benchmarks.robot_sets.trial import Physics

MODULES = (
    laws_body,
    laws_command,
    laws_floor,
    laws_lag,
    laws_motor,
    laws_outside,
    laws_push,
    laws_sensing,
    laws_supply,
)  # they add their laws


def stronger(robot: Robot) -> Setup:
    """Return a robot whose left motor is stronger by 0.05 %."""
    setup, (left, right) = setup_of(robot), robot.plant.stall
    setup.plant = replace(setup.plant, stall=(left * 1.0005, right))
    return setup


SET = RobotSet(
    "ode", GROUPS, TABLE, Physics(setup_of, simulate, NUISANCES, without, stronger), draw_robot, described
)


def _child(pipe: Connection, seed: int, index: int, tries: int, out: Path) -> None:
    pipe.send(SET.tried(seed, index, tries, out))


def apart(seed: int, index: int, tries: int, out: Path) -> dict[str, Any] | str:
    """Make one attempt in a process of its own; the engine ends its process where its solver cannot go on."""
    context = get_context("fork")
    mine, theirs = context.Pipe(duplex=False)
    child = context.Process(target=_child, args=(theirs, seed, index, tries, out))
    child.start()
    theirs.close()
    try:
        found: dict[str, Any] | str = mine.recv()
    except EOFError:
        found = ""
    child.join()
    if not found and child.exitcode != -signal.SIGABRT:
        raise RuntimeError(f"attempt {tries} of robot {index} ended with {child.exitcode}")
    return found or "the engine's solver stopped"


if __name__ == "__main__":
    main(__doc__, partial(robot, apart))
