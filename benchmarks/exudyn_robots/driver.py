"""The person with the joystick: random manoeuvres, and steering back before the edge by the poses seen."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from benchmarks.exudyn_robots.engine import STEP
from benchmarks.exudyn_robots.robots import Setup

Pair = tuple[float, float]
SEEN_LATE = 0.1  # s from a pose to the driver's hand


def _manoeuvre(rng: np.random.Generator, cap: float) -> tuple[float, Callable[[float], Pair]]:
    """Duration s and commands (left, right) over the manoeuvre's own time."""
    kind = rng.choice(
        ["straight", "arc", "spin", "pivot", "s_curve", "ramp", "stop", "reverse", "reverse_arc"],
        p=[0.17, 0.19, 0.1, 0.1, 0.1, 0.1, 0.06, 0.09, 0.09],
    )
    level = float(cap * rng.choice([0.2, 0.35, 0.5, 0.7, 0.85, 1.0]) * rng.uniform(0.9, 1.0))
    side = float(rng.choice([-1.0, 1.0]))
    time = float(rng.uniform(1.2, 3.2))
    if kind == "stop":
        return float(rng.uniform(0.6, 1.4)), lambda t: (0.0, 0.0)
    if kind in ("straight", "reverse"):
        a = level if kind == "straight" else -0.8 * level
        return time, lambda t: (a, a)
    if kind in ("arc", "reverse_arc"):
        inner = float(rng.uniform(0.2, 0.8)) * level
        a, b = (level, inner) if side > 0 else (inner, level)
        back = -0.8 if kind == "reverse_arc" else 1.0
        return time, lambda t: (back * a, back * b)
    if kind == "spin":
        a = 0.7 * level * side
        return min(time, 2.4), lambda t: (-a, a)
    if kind == "pivot":
        a = level * float(rng.choice([-1.0, 1.0, 1.0]))
        return min(time, 2.4), (lambda t: (a, 0.0)) if side > 0 else (lambda t: (0.0, a))
    if kind == "s_curve":
        swing, rate = float(rng.uniform(0.2, 0.5)) * level, float(rng.uniform(2.0, 4.0))
        return time + 1.0, lambda t: (
            level + swing * (math.sin(rate * t) - 1.0),
            level - swing * (math.sin(rate * t) + 1.0),
        )
    sign = float(rng.choice([-1.0, 1.0, 1.0]))
    length = time + 0.8

    def ramp(t: float) -> Pair:
        a = sign * level * min(1.0, 2.0 * min(t, length - t) / length * 1.3)
        return a, a

    return length, ramp


class Driver:
    """Decides commands at the command rate; keeps them in `log`."""

    def __init__(self, setup: Setup, spots: np.ndarray, rng: np.random.Generator) -> None:
        self.setup, self.spots, self.rng = setup, spots, rng
        self.cap = min(1.0, 0.65 / setup.top)
        self.log: list[Pair] = []
        self.plan: Callable[[float], Pair] = lambda t: (0.0, 0.0)
        self.since, self.until = 0.0, 2.0
        self.goal: np.ndarray | None = None
        self.level = 0.5

    def _seen(self, t: float, history: np.ndarray) -> np.ndarray:
        """The pose on the driver's screen (x, y, theta): late, through the robot's sensing."""
        k = (
            int(max(t - SEEN_LATE - self.setup.sensing.pose_delay, 0.0) / max(history[1, 0], 1e-9))
            if len(history) > 1
            else 0
        )
        return self.setup.sensing.report(history[min(k, len(history) - 1) :][:1, 1:4])[0][0]

    def _head_for(self, target: np.ndarray, t: float, level: float) -> None:
        self.goal, self.level = target, level
        self.since, self.until = t, t + 7.0

    def decide(self, t: float, history: np.ndarray) -> Pair:
        """Commands from time t on."""
        x, y, h = self._seen(t, history) if len(history) else (0.0, 0.0, 0.0)
        edge = self.setup.half_area - max(0.35, 0.9 * float(self.setup.par["axle"][0]))
        if self.goal is not None:
            dx, dy = self.goal[0] - x, self.goal[1] - y
            turn = math.atan2(math.sin(math.atan2(dy, dx) - h), math.cos(math.atan2(dy, dx) - h))
            if math.hypot(dx, dy) < 0.25 or t > self.until:
                self.goal, self.until = None, t
            else:
                spin = max(-0.6, min(0.6, 0.7 * turn)) * self.level
                ahead = self.level * max(0.0, math.cos(turn)) if abs(turn) < 1.2 else 0.0
                return self._limit(ahead - spin, ahead + spin)
        if t >= self.until:
            if len(self.log) and self.rng.random() < 0.3:
                spot = self.spots[int(self.rng.integers(len(self.spots)))]
                self._head_for(
                    spot + 0.1 * self.rng.standard_normal(2), t, self.cap * self.rng.uniform(0.4, 0.9)
                )
                return self.decide(t, history)
            time, self.plan = _manoeuvre(self.rng, self.cap)
            self.since, self.until = t, t + time
        left, right = self.plan(t - self.since)
        going = left + right
        out = (abs(x) > edge and x * math.cos(h) * going > 0.0) or (
            abs(y) > edge and y * math.sin(h) * going > 0.0
        )
        if out and t > 2.0:
            self._head_for(
                0.35 * self.setup.half_area * self.rng.uniform(-1.0, 1.0, 2),
                t,
                self.cap * self.rng.uniform(0.4, 0.8),
            )
            return self.decide(t, history)
        return self._limit(left, right)

    def _limit(self, left: float, right: float) -> Pair:
        return max(-1.0, min(1.0, left)), max(-1.0, min(1.0, right))


class Commands:
    """What acts on the motors at t: from a driver (and logged) or from a table; late where the setup
    says so.
    """

    def __init__(self, setup: Setup, driver: Driver | None = None, table: np.ndarray | None = None) -> None:
        self.driver = driver
        self.setup = setup
        self.period = 1.0 / setup.sensing.command_hz
        self.log: list[Pair] = [] if table is None else [(float(a), float(b)) for a, b in table]

    def __call__(self, t: float, history: np.ndarray) -> Pair:
        """Commands acting at t."""
        if self.driver is not None and t >= len(self.log) * self.period - 0.1 * STEP:
            left, right = self.driver.decide(t, history)
            self.log.append((round(left, 5), round(right, 5)))
            self.driver.log = self.log
        late = t - self.setup.command_delay
        poll = self.setup.command_poll
        if poll > 0.0:  # the firmware looks only every `poll` seconds
            late = math.floor(t / poll + 1e-9) * poll - self.setup.command_delay
        if late < 0.0:
            return 0.0, 0.0
        return self.log[min(int(late / self.period + 1e-6), len(self.log) - 1)]
