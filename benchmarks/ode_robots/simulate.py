"""Drive a robot in the Open Dynamics Engine for a while."""

from __future__ import annotations

from benchmarks.ode_robots.engine import STEP
from benchmarks.ode_robots.machine import Machine
from benchmarks.ode_robots.setup import Setup
from benchmarks.robot_sets.driving import Drive, Place, Teller, driven


def simulate(setup: Setup, tell: Teller, seconds: float, run: int, start: Place, step: float = STEP) -> Drive:
    """Return a drive from `start`; `tell` is asked for the wheels' commands at every tick."""
    return driven(Machine(setup, run, start, step), setup.robot, tell, seconds, step)
