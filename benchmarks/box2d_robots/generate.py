"""Simulate robots with hidden effects in Box2D; write their recordings and a key.

python benchmarks/box2d_robots/generate.py --seed 1 --robots 12 --out DIR [--only 0,3] [--verbose]
"""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.box2d_robots import (
    laws_body,
    laws_command,
    laws_driver,
    laws_floor,
    laws_motor,
    laws_outside,
    laws_outside_own,
    laws_push,
    laws_sensing,
    laws_supply,
    laws_tyre,
)
from benchmarks.box2d_robots.laws import GROUPS, LAWS
from benchmarks.box2d_robots.parts import Robot, Setup, setup_of
from benchmarks.box2d_robots.robots import NUISANCES, described, draw_robot, without
from benchmarks.box2d_robots.simulate import simulate
from benchmarks.robot_sets.command_line import main
from benchmarks.robot_sets.robot_set import RobotSet, robot
from benchmarks.robot_sets.trial import Physics

MODULES = (
    laws_body,
    laws_command,
    laws_driver,
    laws_floor,
    laws_motor,
    laws_outside,
    laws_outside_own,
    laws_push,
    laws_sensing,
    laws_supply,
    laws_tyre,
)  # they add their laws


def stronger(robot: Robot) -> Setup:
    """Return a robot whose left motor is stronger by 0.05 %."""
    left, right = robot.plant.torque_const
    return setup_of(robot.changed(torque_const=(left * 1.0005, right)))


SET = RobotSet(
    "box2d", GROUPS, LAWS, Physics(setup_of, simulate, NUISANCES, without, stronger), draw_robot, described
)

if __name__ == "__main__":
    main(__doc__, partial(robot, SET.tried))
