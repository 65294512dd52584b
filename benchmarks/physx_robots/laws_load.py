"""Laws of load: something heavy that rides off the middle."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

from benchmarks.physx_robots.laws import DUTY, Law, log_uniform, register, sign
from benchmarks.physx_robots.robots import Rng, Robot


def with_load(robot: Robot, mass: float, place: tuple[float, float, float]) -> Robot:
    """Return the robot with a block of `mass` [kg] fixed at (x, y, height over the axle) [m]."""
    total = robot.mass + mass
    share = mass / total
    centre = [c + share * (p - c) for c, p in zip(robot.centre, place)]
    apart = [p - c for c, p in zip(robot.centre, place)]
    reduced = robot.mass * share
    about = (
        robot.inertia[0] + reduced * (apart[1] ** 2 + apart[2] ** 2),
        robot.inertia[1] + reduced * (apart[0] ** 2 + apart[2] ** 2),
        robot.inertia[2] + reduced * (apart[0] ** 2 + apart[1] ** 2),
    )
    return replace(robot, mass=total, centre=(centre[0], centre[1], centre[2]), inertia=about)


class Load(Law):
    """A load of `mass_kg` at (x_m, y_m)."""

    mass_kg: float
    x_m: float
    y_m: float
    rise = 0.3

    def build(self, robot: Robot) -> Robot:
        """Return the loaded robot; the load's height over the axle is `rise` wheel radii and a little."""
        return with_load(robot, self.mass_kg, (self.x_m, self.y_m, self.rise * robot.radius))


def _place(rng: Rng, robot: Robot) -> tuple[float, float]:
    """Return a place that keeps the robot on its feet: towards the caster, or beside the middle."""
    towards = robot.casters[0].x * float(rng.uniform(0.1, 0.75))
    return towards, sign(rng) * robot.axle * float(rng.uniform(0.08, 0.38))


@register
@dataclass(frozen=True)
class LowBlock(Load):
    """A block on the lower deck, to one side."""

    label, law, grows, span = "payload_offset", "low_block", {"mass_kg": 1}, (0.02, 60.0)
    needs = DUTY
    cause = "a spare battery or tool box strapped to one side of the lower deck"
    mass_kg: float
    x_m: float
    y_m: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw mass and place."""
        return cls(robot.mass * log_uniform(rng, 0.25, 1.0), *_place(rng, robot))


@register
@dataclass(frozen=True)
class TallStack(Load):
    """The same high up, which also leans on the wheels when the robot speeds up and turns."""

    label, law, grows, span = "payload_offset", "tall_stack", {"mass_kg": 1}, (0.02, 60.0)
    needs = DUTY
    cause = "a laptop or an arm on the upper deck: weight moves between the wheels in turns"
    rise = 0.8
    mass_kg: float
    x_m: float
    y_m: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw mass and place."""
        return cls(robot.mass * log_uniform(rng, 0.25, 0.8), *_place(rng, robot))
