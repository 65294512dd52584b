"""A driver that tells varied commands and turns back at the edge of its area, by the poses that it sees."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

Rng = np.random.Generator
Pose = tuple[float, float, float]
Shares = tuple[float, float]  # forward and turning, of full speed


def start_of(rng: Rng, area: float) -> Pose:
    """Return where a run begins."""
    r, at = 0.3 * area * math.sqrt(rng.random()), rng.uniform(-math.pi, math.pi)
    return float(r * math.cos(at)), float(r * math.sin(at)), float(rng.uniform(-math.pi, math.pi))


def _speed(rng: Rng) -> float:
    return float(rng.uniform(0.12, 0.85))


def _sign(rng: Rng) -> float:
    return float(rng.choice([-1.0, 1.0]))


def _hold(v: float, w: float, seconds: float) -> Iterator[tuple[float, Callable[[float], Shares]]]:
    yield seconds, lambda t: (v, w)


Piece = Iterator[tuple[float, Callable[[float], Shares]]]


def straight(rng: Rng) -> Piece:
    """Drive straight, one speed after another."""
    for _ in range(int(rng.integers(1, 4))):
        yield from _hold(_speed(rng), 0.0, rng.uniform(0.7, 2.0))


def arc(rng: Rng) -> Piece:
    """Drive an arc, forwards or backwards."""
    v = _speed(rng)
    yield from _hold(
        v * (1.0 if rng.random() < 0.75 else -0.8), v * rng.uniform(-0.7, 0.7), rng.uniform(1.2, 3.0)
    )


def spin(rng: Rng) -> Piece:
    """Turn on the spot, one way and perhaps the other."""
    w = rng.uniform(0.1, 0.55) * _sign(rng)
    yield from _hold(0.0, w, rng.uniform(0.8, 2.2))
    if rng.random() < 0.5:
        yield from _hold(0.0, -w * rng.uniform(0.5, 1.2), rng.uniform(0.6, 1.6))


def pivot(rng: Rng) -> Piece:
    """Turn about one standing wheel."""
    v = 0.5 * _speed(rng) * _sign(rng)
    yield from _hold(v, v * _sign(rng), rng.uniform(0.8, 1.8))


def reverse(rng: Rng) -> Piece:
    """Go to and fro."""
    v = _speed(rng)
    for _ in range(int(rng.integers(1, 3))):
        yield from _hold(v, 0.0, rng.uniform(0.5, 1.3))
        yield from _hold(-v * rng.uniform(0.6, 1.1), rng.uniform(-0.08, 0.08), rng.uniform(0.5, 1.3))


def ramp(rng: Rng) -> Piece:
    """Speed up and slow down evenly, straight or on a curve."""
    top, bend, length = _speed(rng) * _sign(rng), rng.uniform(-0.35, 0.35), rng.uniform(2.0, 4.5)
    start = rng.uniform(-0.1, 0.1)

    def told(t: float) -> Shares:
        v = start + (top - start) * (1.0 - abs(2.0 * t / length - 1.0))
        return v, bend * v

    yield length, told


def stop_and_go(rng: Rng) -> Piece:
    """Start and stop several times."""
    for _ in range(int(rng.integers(2, 5))):
        yield from _hold(
            _speed(rng) * (1.0 if rng.random() < 0.7 else -1.0), rng.uniform(-0.1, 0.1), rng.uniform(0.4, 1.0)
        )
        yield from _hold(0.0, 0.0, rng.uniform(0.25, 0.7))


def slalom(rng: Rng) -> Piece:
    """Swing from side to side."""
    v, w, rate, length = _speed(rng), rng.uniform(0.08, 0.35), rng.uniform(1.5, 5.0), rng.uniform(2.5, 5.0)
    yield length, lambda t: (v, w * math.sin(rate * t))


def creep(rng: Rng) -> Piece:
    """Drive very slowly."""
    v = rng.uniform(0.03, 0.12) * _sign(rng)
    yield from _hold(v, rng.uniform(-0.05, 0.05), rng.uniform(1.2, 2.5))


def rest(rng: Rng) -> Piece:
    """Stand."""
    yield from _hold(0.0, 0.0, rng.uniform(0.5, 2.0))


PIECES = (straight, arc, arc, spin, pivot, reverse, ramp, stop_and_go, slalom, creep, rest)


class Driver:
    """Tells commands, one for each tick; sees noisy poses."""

    def __init__(self, rng: Rng, area: float, tick: float, noise: float) -> None:
        """Begin with a piece of driving."""
        self.rng, self.area, self.tick, self.noise = rng, area, tick, noise
        self.deck: list[int] = []
        self.piece: Piece = iter(())
        self.left, self.at = 0.0, 0.0
        self.told: Callable[[float], Shares] = lambda t: (0.0, 0.0)
        self.home: tuple[float, float, float] | None = None

    def _next(self) -> None:
        while True:
            step = next(self.piece, None)
            if step is not None:
                self.left, self.told, self.at = float(step[0]), step[1], 0.0
                return
            if not self.deck:
                self.deck = [int(k) for k in self.rng.permutation(len(PIECES))]
            self.piece = PIECES[self.deck.pop()](self.rng)

    def __call__(self, pose: Pose) -> Shares:
        """Return the commands of left and right wheel for the next tick."""
        x = pose[0] + self.rng.normal(0.0, self.noise)
        y = pose[1] + self.rng.normal(0.0, self.noise)
        yaw = pose[2] + self.rng.normal(0.0, 0.01)
        v, w = self._shares(x, y, yaw)
        return min(max(v - w, -1.0), 1.0), min(max(v + w, -1.0), 1.0)

    def _shares(self, x: float, y: float, yaw: float) -> Shares:
        out = math.hypot(x, y)
        if self.home is None:
            if self.left <= 0.0:
                self._next()
            v, w = self.told(self.at)
            heads_out = v * (x * math.cos(yaw) + y * math.sin(yaw)) > 0.0
            if out > self.area or (out > 0.85 * self.area and heads_out):
                r, at = 0.35 * self.area, self.rng.uniform(-math.pi, math.pi)
                self.home = (r * math.cos(at), r * math.sin(at), self.rng.uniform(0.35, 0.8))
            else:
                self.left -= self.tick
                self.at += self.tick
                return v, w
        gx, gy, speed = self.home
        off = math.remainder(math.atan2(gy - y, gx - x) - yaw, 2.0 * math.pi)
        if math.hypot(gx - x, gy - y) < 0.25 * self.area:
            self.home, self.left = None, 0.0
        turn = min(max(0.5 * off, -0.4), 0.4)
        return speed * max(math.cos(off), 0.0) ** 2, turn
