"""A person at the controls: moves of all kinds, and turning back before the edge of the floor."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

REACH = 1.3  # m from the centre that a planned move may end at, in x and in y
TURN_BACK = 0.85  # m from the centre at which the driver turns back
FASTEST = 0.8  # m/s
QUICKEST = 3.5  # rad/s of turning
MOVES = (
    "straight", "arc", "arc", "s_curve", "spin", "pivot", "stop_and_go", "rest", "ramp", "shuttle",
    "creep", "dash",
)  # fmt: skip

Leg = tuple[float, float, float]
"""Seconds, left command, right command."""


@dataclass(frozen=True)
class Knows:
    """What the driver knows of the robot."""

    top_speed: float
    axle: float


class Driver:
    """Plans a move at a time from the true pose, so that the robot stays on its floor."""

    def __init__(
        self, rng: np.random.Generator, knows: Knows, tick: float, seconds: float, spot: tuple[float, float]
    ):
        self.rng, self.knows, self.tick, self.seconds = rng, knows, tick, seconds
        self.spots = ((0.0, 0.0), spot)
        self.legs: list[Leg] = [(float(rng.uniform(0.8, 1.6)), 0.0, 0.0)]
        self.until = -1.0
        self.now = (0.0, 0.0)

    def command(self, time: float, x: float, y: float, theta: float) -> tuple[float, float]:
        """Return the command at a tick."""
        if time < self.until - self.tick / 2:
            return self.now
        if time > self.seconds - 1.2:
            self.until, self.now = math.inf, (0.0, 0.0)
            return self.now
        if not self.legs:
            self.legs = self._softened(self._plan(x, y, theta))
        span, left, right = self.legs.pop(0)
        ticks = max(1, round(span / self.tick))
        self.until = time + ticks * self.tick
        self.now = (round(max(-1.0, min(1.0, left)), 4), round(max(-1.0, min(1.0, right)), 4))
        return self.now

    def _softened(self, legs: list[Leg]) -> list[Leg]:
        """Put short legs between before large changes."""
        soft: list[Leg] = []
        left, right = self.now
        for span, new_left, new_right in legs:
            pieces = math.ceil(max(abs(new_left - left), abs(new_right - right)) / 0.6)
            for k in range(1, pieces):
                share = k / pieces
                soft.append((0.2, left + share * (new_left - left), right + share * (new_right - right)))
            soft.append((span, new_left, new_right))
            left, right = new_left, new_right
        return soft

    def _plan(self, x: float, y: float, theta: float) -> list[Leg]:
        rng = self.rng
        if math.hypot(x, y) > TURN_BACK or rng.random() < 0.2:
            spot = self.spots[int(rng.integers(2))]
            goal_x, goal_y = spot[0] + rng.normal(0, 0.15), spot[1] + rng.normal(0, 0.15)
            if math.hypot(goal_x - x, goal_y - y) > 0.25:
                return self._go(x, y, theta, goal_x, goal_y)
        for _ in range(15):
            legs = self._move(str(rng.choice(MOVES)))
            if self._stays(x, y, theta, legs):
                return legs
        return self._go(x, y, theta, *self.spots[0])

    def _stays(self, x: float, y: float, theta: float, legs: list[Leg]) -> bool:
        for span, left, right in legs:
            speed = (left + right) / 2 * self.knows.top_speed
            turn = (right - left) * self.knows.top_speed / self.knows.axle
            for _ in range(8):
                theta += turn * span / 16
                x += speed * span / 8 * math.cos(theta)
                y += speed * span / 8 * math.sin(theta)
                theta += turn * span / 16
                if max(abs(x), abs(y)) > REACH:
                    return False
        return True

    def _spin(self, angle: float) -> Leg:
        """Return a turn on the spot by an angle [rad]."""
        quickest = min(QUICKEST, 2 * self.knows.top_speed / self.knows.axle * 0.8)
        rate = float(self.rng.uniform(0.3, 0.8)) * quickest
        span = min(3.0, max(abs(angle) / rate, 0.4))
        share = min(0.9, abs(angle) / span * self.knows.axle / 2 / self.knows.top_speed)
        share = math.copysign(share, angle)
        return span, -share, share

    def _go(self, x: float, y: float, theta: float, goal_x: float, goal_y: float) -> list[Leg]:
        """Face a goal, or turn the back to it, and drive there."""
        rng, way = self.rng, 1.0
        angle = math.remainder(math.atan2(goal_y - y, goal_x - x) - theta, 2 * math.pi)
        if abs(angle) > 2.0 or rng.random() < 0.25:
            angle, way = math.remainder(angle + math.pi, 2 * math.pi), -1.0
        legs: list[Leg] = [self._spin(angle)] if abs(angle) > 0.15 else []
        far = math.hypot(goal_x - x, goal_y - y)
        share = min(float(rng.uniform(0.3, 0.95)), FASTEST / self.knows.top_speed)
        span = max(far / share / self.knows.top_speed, 0.4)
        share = far / span / self.knows.top_speed
        pieces = math.ceil(span / 3.0)
        weave = float(rng.uniform(-0.08, 0.08)) if pieces == 1 else 0.0
        legs += [(span / pieces, way * share * (1 - weave), way * share * (1 + weave))] * min(pieces, 2)
        return legs

    def _level(self, low: float, high: float) -> float:
        """Return a share of full command, limited to what the floor has room for, with a direction."""
        share = min(float(self.rng.uniform(low, high)), FASTEST / self.knows.top_speed)
        return share if self.rng.random() < 0.6 else -share

    def _any_level(self) -> float:
        low, high = ((0.07, 0.25), (0.25, 0.6), (0.6, 1.0))[int(self.rng.choice(3, p=[0.3, 0.45, 0.25]))]
        return self._level(low, high)

    def _span(self, low: float, high: float, level: float) -> float:
        """Return a time within which the robot goes at most about a metre."""
        return max(0.4, min(float(self.rng.uniform(low, high)), 1.1 / abs(level) / self.knows.top_speed))

    def _bent(self, level: float, left_turn: bool) -> tuple[float, float]:
        """Return the commands of an arc whose outer wheel has `level`."""
        inner = float(self.rng.uniform(0.2, 0.85))
        most = QUICKEST * self.knows.axle / self.knows.top_speed / abs(level)
        inner = max(inner, 1.0 - most)
        return (level * inner, level) if left_turn else (level, level * inner)

    def _move(self, name: str) -> list[Leg]:
        rng, left_turn = self.rng, bool(self.rng.random() < 0.5)
        level = self._any_level()
        if name == "straight":
            return [(self._span(0.6, 3.0, level), level, level)]
        if name == "arc":
            return [(self._span(0.8, 3.0, level), *self._bent(level, left_turn))]
        if name == "s_curve":
            left, right = self._bent(level, left_turn)
            span = self._span(0.6, 1.6, level)
            return [(span, left, right), (span, right, left)]
        if name == "spin":
            return [self._spin(float(rng.uniform(0.5, 3.6)) * (1 if left_turn else -1))]
        if name == "pivot":
            most = QUICKEST * self.knows.axle / self.knows.top_speed
            level = math.copysign(min(abs(level), most, 1.0), level)
            return [(float(rng.uniform(0.5, 1.5)), *((0.0, level) if left_turn else (level, 0.0)))]
        if name == "stop_and_go":
            legs: list[Leg] = []
            for _ in range(int(rng.integers(2, 4))):
                legs.append((self._span(0.4, 0.9, level), level, level * float(rng.uniform(0.9, 1.0))))
                legs.append((float(rng.uniform(0.4, 0.8)), 0.0, 0.0))
            return legs
        if name == "rest":
            return [(float(rng.uniform(0.5, 1.4)), 0.0, 0.0)]
        if name == "ramp":
            steps = int(rng.integers(4, 7))
            return [(0.4, level * (k + 1) / steps, level * (k + 1) / steps) for k in range(steps)]
        if name == "shuttle":
            span = self._span(0.5, 1.2, level)
            return [(span, level, level), (span, -level, -level), (span, level, level)]
        if name == "creep":
            level = self._level(0.04, 0.16)
            return [(float(rng.uniform(1.2, 2.6)), *self._bent(level, left_turn))]
        level = self._level(0.75, 1.0)
        return [(self._span(0.5, 1.5, level), level, level)]
