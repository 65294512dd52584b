"""One drive: an operator (or a list of command rows) moves a setup in an engine; the true track comes out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from foreign.motor import MOTOR_STATES, ROTOR_ANGLE, VOLTS
from foreign.pilot import Pilot, clipped
from foreign.planar import BODY_STATES, HOOKS, MU_L, PHL, PHR, SLACK_R, STEP, THETA, R, U, V, X, Y, advance
from foreign.setup import Array, Setup

TICK = 20  # steps between two calls of hooks: 10 ms
EVERY = 20  # steps between two rows of the true track: 10 ms


class Engine(Protocol):
    """A simulator that has been given a setup and a start pose."""

    def forward(self, duty: Array) -> Array:
        """Drive by duties (k, 2) on a grid of 0.5 ms; return rows every 10 ms: x, y, theta, vx, vy, omega, phl, phr."""
        ...


class Planar:
    """The planar robot of `foreign.planar`."""

    def __init__(self, setup: Setup, pose: Array) -> None:
        self.setup, self.time = setup, 0.0
        self.left, self.right = setup.motors()
        self.supply, self.body = setup.battery(), setup.frame()
        self.ml, self.mr = np.zeros(MOTOR_STATES), np.zeros(MOTOR_STATES)
        self.pack = np.zeros(3)
        self.pack[VOLTS] = 1.0
        c, s = np.cos(pose[2]), np.sin(pose[2])
        self.q = np.zeros(BODY_STATES)
        self.q[:3] = pose
        self.q[X] += c * self.body.com_x - s * self.body.com_y
        self.q[Y] += s * self.body.com_x + c * self.body.com_y
        self.ml[ROTOR_ANGLE] = self.mr[ROTOR_ANGLE] = 0.0

    def rows(self, q: Array) -> Array:
        """Turn states of the centre of mass (k, 11) into rows of the axle centre (k, 8)."""
        c, s = np.cos(q[:, THETA]), np.sin(q[:, THETA])
        bx, by = self.body.com_x, self.body.com_y
        u, v = q[:, U] + q[:, R] * by, q[:, V] - q[:, R] * bx
        x, y = q[:, X] - c * bx + s * by, q[:, Y] - s * bx - c * by
        return np.column_stack(
            [x, y, q[:, THETA], c * u - s * v, s * u + c * v, q[:, R], q[:, PHL], q[:, PHR]]
        )

    def forward(self, duty: Array) -> Array:
        size = TICK if self.setup.hooks else max(len(duty), 1)
        parts = []
        for k in range(0, len(duty), size):
            chunk = duty[k : k + size]
            hook = np.zeros(HOOKS)
            hook[MU_L : SLACK_R + 1] = 1.0
            if self.setup.hooks:
                state = self.rows(self.q[None])[0, :6]
                for act in self.setup.hooks:
                    act(self.time, state, hook)
            out = np.empty((len(chunk) // EVERY, BODY_STATES))
            advance(
                chunk,
                self.q,
                self.ml,
                self.mr,
                self.pack,
                hook,
                self.left,
                self.right,
                self.supply,
                self.body,
                out,
                EVERY,
            )
            self.time += len(chunk) * STEP
            parts.append(out)
        return self.rows(np.concatenate(parts))


def start_engine(setup: Setup, pose: Array) -> Engine:
    """Return the engine that a setup asks for."""
    if setup.engine == "mujoco":
        from foreign.mujoco_engine import MuJoCo

        return MuJoCo(setup, pose)
    if setup.engine == "pybullet":
        from foreign.bullet_engine import Bullet

        return Bullet(setup, pose)
    if setup.engine == "drake":
        from foreign.drake_engine import Drake

        return Drake(setup, pose)
    return Planar(setup, pose)


@dataclass
class Drive:
    """Command rows (times (n,), duties (n, 2)) and the true track: grid (k,) s, rows (k, 8)."""

    times: Array
    duties: Array
    grid: Array
    rows: Array


def on_grid(setup: Setup, times: Array, duties: Array, steps: int, seed: int) -> Array:
    """Return duties (steps, 2) at the motors: link laws, hold, driver laws, 0.4 % of slow noise."""
    for rule in setup.rows:
        times, duties = rule(times, duties)
    grid = np.arange(steps) * STEP
    index = np.searchsorted(times, grid, side="right") - 1
    duty = np.where(index[:, None] >= 0, duties[np.maximum(index, 0)], 0.0)
    for act in setup.samples:
        duty = act(grid, duty)
    draws = np.random.default_rng(seed).normal(size=(1600, 2))
    noise = np.column_stack([np.interp(grid, np.arange(1600) * 0.1, draws[:, i]) for i in range(2)])
    return np.clip(duty * (1.0 + 0.004 * noise), -1.0, 1.0)


def steps_of(seconds: float) -> int:
    """Whole hook intervals in a time, rounded down: what comes later is not yet known."""
    return int(seconds / (STEP * TICK) + 1e-6) * TICK


def replay(setup: Setup, pose: Array, times: Array, duties: Array, seconds: float, seed: int) -> Drive:
    """Drive by given command rows."""
    steps = steps_of(seconds)
    rows = start_engine(setup, pose).forward(on_grid(setup, times, duties, steps, seed))
    return Drive(times, duties, (np.arange(len(rows)) + 1) * STEP * EVERY, rows)


def piloted(setup: Setup, pose: Array, pilot: Pilot, seconds: float, seed: int, rounding) -> Drive:
    """Let an operator drive; `rounding(duties)` is what the log keeps of a command."""
    engine, total = start_engine(setup, pose), steps_of(seconds)
    times, duties, parts, done = [0.0], [np.zeros(2)], [], steps_of(0.8)
    at = done * STEP
    parts.append(engine.forward(on_grid(setup, np.array(times), np.array(duties), done, seed)))
    while done < total:
        for span, a, b in clipped(pilot.next(parts[-1][-1])):
            times.append(round(at, 5))
            duties.append(rounding(np.array([a, b])))
            at += span
        until = min(steps_of(at), total)
        if until <= done:
            continue
        whole = on_grid(setup, np.array(times), np.array(duties), until, seed)
        parts.append(engine.forward(whole[done:]))
        done = until
    rows = np.concatenate(parts)
    keep = np.array(times) < seconds
    return Drive(
        np.array(times)[keep], np.array(duties)[keep], (np.arange(len(rows)) + 1) * STEP * EVERY, rows
    )
