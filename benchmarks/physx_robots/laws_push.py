"""Laws of what pushes the robot for a moment."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from benchmarks.physx_robots.laws import Law, Process, log_uniform, register
from benchmarks.physx_robots.robots import GRAVITY, Rng, Robot
from benchmarks.physx_robots.simulate import Drive, State

Moment = tuple[float, float, float, float]
"""Start and length [s], direction of the world [rad], place on the robot [rad from ahead]."""


class Pushed(Process):
    """Pushes at their moments."""

    def __init__(self, law: Push, moments: list[Moment]) -> None:
        self.law, self.moments = law, moments

    def force(self, state: State) -> None:
        """Add the push of a moment that lasts."""
        for start, length, angle, place in self.moments:
            if start <= state.t < start + length:
                robot = state.robot
                size = (
                    self.law.force * robot.total_mass * GRAVITY * self.law.shape((state.t - start) / length)
                )
                arm = 0.5 * robot.axle
                dx, dy = arm * math.cos(state.yaw + place), arm * math.sin(state.yaw + place)
                state.push(size * math.cos(angle), size * math.sin(angle), dx, dy)


@dataclass(frozen=True)
class Push(Law):
    """Pushes of up to `force` of the robot's weight, at moments that each run draws."""

    local = True
    force: float
    lengths: tuple[float, float]

    def shape(self, part: float) -> float:
        """Return the force over its largest at a part (0..1) of the moment."""
        raise NotImplementedError

    def moments(self, rng: Rng) -> list[Moment]:
        """Return two to four moments of a run."""
        starts = np.sort(rng.uniform(4.0, 50.0, int(rng.integers(2, 5))))
        return [
            (
                float(s),
                float(rng.uniform(*self.lengths)),
                float(rng.uniform(-3.14, 3.14)),
                float(rng.uniform(-3.14, 3.14)),
            )
            for s in starts
        ]

    def process(self, rng: Rng) -> Process:
        """Return the pushes."""
        return Pushed(self, self.moments(rng))

    def touched(self, drive: Drive, rng: Rng) -> np.ndarray:
        """Return the moments as a mask, with half a second after each."""
        mask = np.zeros(len(drive.time), dtype=bool)
        for start, length, _, _ in self.moments(rng):
            mask |= (drive.time >= start) & (drive.time < start + length + 0.5)
        return mask


@register
@dataclass(frozen=True)
class Shove(Push):
    """A foot or hand knocks the robot: half a sine of 0.15 to 0.5 s."""

    label, law, grows, span = "external_push", "shove", {"force": 1}, (0.01, 1.8)
    cause = "a person who bumps into it, or another robot (impact pulses of soft bodies last 0.1 to 0.5 s)"

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the force."""
        return cls(log_uniform(rng, 0.25, 1.0), (0.15, 0.5))

    def shape(self, part: float) -> float:
        """Return half a sine."""
        return math.sin(math.pi * part)


@register
@dataclass(frozen=True)
class Lean(Push):
    """Somebody holds or leans on the robot for 0.8 to 2.5 s: a trapezoid."""

    label, law, grows, span = "external_push", "lean", {"force": 1}, (0.01, 1.2)
    cause = "a hand that holds it back, or a child that pushes along"

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the force."""
        return cls(log_uniform(rng, 0.1, 0.5), (0.8, 2.5))

    def shape(self, part: float) -> float:
        """Return the trapezoid."""
        return min(1.0, 5.0 * part, 5.0 * (1.0 - part))
