"""A driver that mixes manoeuvres and stays in its area by what it sees."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

Rng = np.random.Generator
Aim = tuple[float, float]


class Driver:
    """Source of commands: a shuffled deck of manoeuvres; turns back when the pose it sees leaves the area.

    area [m]: radius; noise [m]; commands are multiples of 0.01 and change by at most `slew` a second.
    """

    def __init__(self, rng: Rng, area: float, tick: float, noise: float) -> None:
        self.rng, self.area, self.tick, self.noise = rng, area, tick, noise
        self.slew = float(rng.uniform(1.6, 3.0))
        self.now = [0.0, 0.0]
        self.deck: list[str] = []
        self.moves = self._rest(1.0)
        self.home = False
        self.pose = (0.0, 0.0, 0.0)

    def __call__(self, t: float, x: float, y: float, yaw: float) -> Aim:
        """Return the commands for the next tick."""
        self.pose = (
            x + float(self.rng.normal(0, self.noise)),
            y + float(self.rng.normal(0, self.noise)),
            yaw,
        )
        if not self.home and math.hypot(*self.pose[:2]) > self.area:
            self.home, self.moves = True, self._return()
        aim = next(self.moves, None)
        while aim is None:
            self.home, self.moves = False, self._next()
            aim = next(self.moves, None)
        most = self.slew * self.tick
        for k in (0, 1):
            self.now[k] += min(max(aim[k] - self.now[k], -most), most)
        return round(self.now[0], 3), round(self.now[1], 3)

    def _next(self) -> Iterator[Aim]:
        if not self.deck:
            names = [
                "straight",
                "straight",
                "arc",
                "arc",
                "spin",
                "pivot",
                "back",
                "ramp",
                "stop_go",
                "slalom",
                "rest",
            ]
            self.deck = [str(n) for n in self.rng.permutation(names)]
        name = self.deck.pop()
        way: Iterator[Aim] = getattr(self, f"_{name}")()
        return way

    def _u(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))

    def _sign(self) -> float:
        return float(self.rng.choice((-1.0, 1.0)))

    def _hold(self, seconds: float, left: float, right: float) -> Iterator[Aim]:
        left, right = round(left, 2), round(right, 2)
        for _ in range(round(seconds / self.tick)):
            yield left, right

    def _rest(self, seconds: float | None = None) -> Iterator[Aim]:
        yield from self._hold(seconds or self._u(0.5, 1.3), 0.0, 0.0)

    def _straight(self) -> Iterator[Aim]:
        u = self._u(0.25, 0.95)
        yield from self._hold(self._u(1.5, 3.0), u, u)

    def _arc(self) -> Iterator[Aim]:
        u, bend = self._u(0.35, 0.8), self._sign() * self._u(0.1, 0.5)
        yield from self._hold(self._u(1.5, 3.5), u * (1 - bend), u * (1 + bend))

    def _spin(self) -> Iterator[Aim]:
        u = self._sign() * self._u(0.15, 0.5)
        yield from self._hold(self._u(1.0, 2.2), -u, u)

    def _pivot(self) -> Iterator[Aim]:
        u = self._sign() * self._u(0.25, 0.6)
        yield from self._hold(self._u(1.0, 2.0), *((0.0, u) if self.rng.random() < 0.5 else (u, 0.0)))

    def _back(self) -> Iterator[Aim]:
        u, bend = -self._u(0.25, 0.7), self._sign() * self._u(0.0, 0.35)
        yield from self._hold(self._u(1.2, 2.5), u * (1 - bend), u * (1 + bend))

    def _ramp(self) -> Iterator[Aim]:
        top, bend, seconds = self._u(0.6, 1.0), self._u(-0.15, 0.15), self._u(2.0, 3.5)
        steps = round(seconds / self.tick)
        for n in range(steps):
            u = top * (1.0 - abs(2.0 * n / steps - 1.0))
            yield round(u * (1 - bend), 2), round(u * (1 + bend), 2)

    def _stop_go(self) -> Iterator[Aim]:
        u = self._sign() * self._u(0.3, 0.8)
        for _ in range(int(self.rng.integers(2, 4))):
            yield from self._hold(self._u(0.5, 0.9), u, u)
            yield from self._hold(self._u(0.3, 0.6), 0.0, 0.0)

    def _slalom(self) -> Iterator[Aim]:
        u, bend, period = self._u(0.4, 0.75), self._u(0.15, 0.4), self._u(1.2, 2.4)
        for n in range(round(self._u(2.5, 4.0) / self.tick)):
            swing = bend * math.sin(2 * math.pi * n * self.tick / period)
            yield round(u * (1 - swing), 2), round(u * (1 + swing), 2)

    def _return(self) -> Iterator[Aim]:
        """Turn towards a point near the middle, then go there."""
        goal = (self._u(-0.3, 0.3) * self.area, self._u(-0.3, 0.3) * self.area)
        u = round(self._u(0.35, 0.8), 2)
        turn = round(self._u(0.18, 0.35), 2)
        for _ in range(round(14.0 / self.tick)):
            x, y, yaw = self.pose
            off = math.remainder(math.atan2(goal[1] - y, goal[0] - x) - yaw, 2 * math.pi)
            if math.hypot(goal[0] - x, goal[1] - y) < 0.3 * self.area:
                return
            if abs(off) > 0.7:
                side = math.copysign(turn, off)
                yield -side, side
            else:
                bend = round(min(max(0.8 * off, -0.4), 0.4), 1)
                yield u * (1 - bend), u * (1 + bend)


def start_of(rng: Rng, area: float) -> tuple[float, float, float]:
    """Return a place and heading to start from [m, rad]."""
    return (
        float(rng.uniform(-0.4, 0.4)) * area,
        float(rng.uniform(-0.4, 0.4)) * area,
        float(rng.uniform(-math.pi, math.pi)),
    )
