"""Drive a robot in Box2D for a while."""

from __future__ import annotations

from benchmarks.box2d_robots.machine import STEP, Machine
from benchmarks.box2d_robots.parts import Setup
from benchmarks.robot_sets.driving import Drive, Place, Teller, driven


def simulate(setup: Setup, tell: Teller, seconds: float, run: int, start: Place, step: float = STEP) -> Drive:
    """Return a drive from `start`; `tell` is asked for the wheels' commands at every tick."""
    return driven(Machine(setup, run, start, step), setup.robot, tell, seconds, step)
