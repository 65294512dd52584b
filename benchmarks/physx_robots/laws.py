"""What a law of an imperfection is: a frozen value with sizes, and the places where it acts."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from benchmarks.physx_robots.robots import Rng, Robot

if TYPE_CHECKING:
    from benchmarks.physx_robots.simulate import Drive, State

DUTY, SPEED = {"drive": "duty"}, {"drive": "speed"}
BRUSH, ENGINE = {"tyre": "brush"}, {"tyre": "engine"}
BALL, SWIVEL = {"caster": "ball"}, {"caster": "swivel"}
"""What a law may need of a robot: driven by duties or by a speed controller, its tyres, its caster."""

Reported = dict[str, np.ndarray]
"""Reported poses on a fine grid: `time` and `stamp` [s], `x`, `y` [m], `yaw` [rad], and the body's `bx`, `by`,
`byaw`.
"""


class Process:
    """What acts while the robot drives; a subclass overrides what it needs."""

    def command(self, state: State, left: float, right: float) -> tuple[float, float]:
        """Return what the electronics make of the commands, every step."""
        return left, right

    def tick(self, state: State) -> None:
        """Change motors, supply, resistances or grips, which are nominal beforehand; every 10 ms."""

    def force(self, state: State) -> None:
        """Add to the level force [N] and moment [N m] on the body, every step."""


@dataclass(frozen=True)
class Law:
    """An imperfection of one size.

    label, law: names for the key; cause: what does it and a source; grows: power of the factor by which each
    field is scaled; span: limits of the first of them; needs: what the robot must have; local: whether it acts
    at some places or moments only.
    """

    label: ClassVar[str | None] = None
    law: ClassVar[str] = ""
    cause: ClassVar[str] = ""
    grows: ClassVar[dict[str, int]] = {}
    span: ClassVar[tuple[float, float]] = (0.0, np.inf)
    needs: ClassVar[dict[str, str]] = {}
    local: ClassVar[bool] = False
    senses: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw sizes, sides and signs for a robot."""
        raise NotImplementedError

    def scaled(self, factor: float) -> Self:
        """Return the law `factor` times as large, within its limits."""
        first = next(iter(self.grows))
        power = self.grows[first]
        size = getattr(self, first)
        clipped = float(np.clip(abs(size) * factor**power, *self.span))
        factor = (clipped / abs(size)) ** (1.0 / power)
        return replace(self, **{k: getattr(self, k) * factor**p for k, p in self.grows.items()})

    def sizes(self) -> dict[str, Any]:
        """Return the sizes as the key states them."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    def build(self, robot: Robot) -> Robot:
        """Return the robot (or its floor) changed for good."""
        return robot

    def process(self, rng: Rng) -> Process | None:
        """Return what acts in one run; `rng` is the run's own and gives the same for the same run."""
        return None

    def observe(self, poses: Reported, rng: Rng) -> Reported:
        """Return the reported poses changed."""
        return poses

    def touched(self, drive: Drive, rng: Rng) -> np.ndarray | None:
        """Return where on the drive's grid a local law acts, as a mask."""
        return None


LAWS: dict[str, list[type[Law]]] = {}
OUTSIDE: list[type[Law]] = []


def register(law: type[Law]) -> type[Law]:
    """Enter a law in the catalogue under its label; laws without one are outside."""
    (LAWS.setdefault(law.label, []) if law.label else OUTSIDE).append(law)
    law.__doc__ = f"{law.__doc__}\n\n    Cause and source: {law.cause}."
    return law


def log_uniform(rng: Rng, low: float, high: float) -> float:
    """Draw between two positive bounds, uniform in the logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def sign(rng: Rng) -> float:
    """Draw -1 or 1."""
    return float(rng.choice([-1.0, 1.0]))


def which(rng: Rng, both: float = 0.4) -> tuple[float, float]:
    """Draw the wheels that a law acts on, as weights of left and right; `both`: the probability of two."""
    if rng.random() < both:
        return 1.0, 1.0
    return (1.0, 0.0) if rng.random() < 0.5 else (0.0, 1.0)


def direction(rng: Rng, size: float = 1.0) -> tuple[float, float]:
    """Draw a vector of a length in any direction."""
    angle = rng.uniform(-np.pi, np.pi)
    return float(size * np.cos(angle)), float(size * np.sin(angle))
