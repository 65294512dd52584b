"""What a law is, and what chance gives it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

OUTSIDE = "outside"
SENSED = ("clock_drift", "misplaced_marker", "observation_delay", "sensor_offset", "sensor_yaw")
"""Labels of laws that act on what is seen, not on the robot."""


@dataclass(frozen=True)
class Draw:
    """What chance gives a law besides its size: numbers in [0, 1), a seed, places [m], seconds, the area [m]."""

    numbers: tuple[float, ...]
    seed: int
    spots: tuple[tuple[float, float], ...]
    seconds: float
    area: float

    def between(self, index: int, low: float, high: float) -> float:
        """Return number `index` between two bounds."""
        return low + (high - low) * self.numbers[index]

    def sign(self, index: int) -> float:
        """Return -1 or 1."""
        return 1.0 if self.numbers[index] < 0.5 else -1.0


Apply = Callable[[Any, float, Draw], dict[str, float]]


@dataclass(frozen=True)
class Law:
    """A law: apply(setup, size, draw) changes the setup and returns its sizes; size lies between low and high.

    local : acts at places or moments; needs : what the robot must have (`duty`: no speed controller).
    """

    label: str
    name: str
    unit: str
    low: float
    high: float
    source: str
    apply: Apply
    local: bool = False
    needs: tuple[str, ...] = ()
