"""Drive a robot for a while and keep the truth of it."""

from __future__ import annotations

import math

import numpy as np

from benchmarks.box2d_robots.machine import STEP, Machine
from benchmarks.box2d_robots.parts import Setup
from benchmarks.ode_robots.simulate import EVERY, FAR, Drive, RanOff, Teller, replay

__all__ = ["Drive", "RanOff", "Teller", "replay", "simulate"]


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
            rows.append((now.x, now.y, now.yaw, float(now.turned[0]), float(now.turned[1]), touched))
            touched = False
            if not math.hypot(now.x, now.y) < limit:
                raise RanOff(f"at {now.t:.1f} s")
        now.touched = False
        machine.advance(told)
        touched = touched or now.touched
    rows.append((now.x, now.y, now.yaw, float(now.turned[0]), float(now.turned[1]), touched))
    kept = np.array([row[:5] for row in rows])
    x, y, yaw, left, right = (np.ascontiguousarray(kept[:, k]) for k in range(5))
    time, marks = np.arange(len(rows)) * EVERY, np.array([row[5] for row in rows])
    return Drive(time, x, y, yaw, left, right, marks, np.array(commands), tick, seconds)
