"""How the bounds of physics follow the robot: a load half a metre off the axle is nothing that a Duckiebot can carry.

Bounds are declared for small robots (`effects`, `parameters.BASE`). Those of a larger or faster one grow by dimension,
mass apart (a fit moves a robot of the base's mass, and forces are weighed by the stated one afterwards):

    length by `length`, speed by `speed`; acceleration, time and ratio stay, gravity and motors being what they are;
    so forces [N] stay, moments [N m] grow by `length`, impulses [N s] by `speed`, angular ones by both
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from fsm_calib.world2d.effects import Parameter
from fsm_calib.world2d.slots import SMALL_AXLE
from fsm_calib.world2d.units import dimension

SMALL_SPEED = 1.0  # m/s at full command: a Duckiebot's 0.6, a Create's 0.5; a Warthog's 5
GROWTH = {(1, 0): (1, 0), (1, -1): (0, 1), (2, -2): (1, 0), (2, -1): (1, 1)}
"""Powers of `length` and `speed` by the powers of length and time, mass taken out; (0, 0) for all others."""


@dataclass(frozen=True, slots=True)
class Scale:
    """By how much [1] a robot is longer and faster than the small ones, 1 at least."""

    length: float = 1.0
    speed: float = 1.0

    @classmethod
    def of(cls, axle_length: float, full_speed: float) -> Scale:
        """Return the scale of a robot by its axle length [m] and its rim speed at full command [m/s]."""
        return cls(max(1.0, axle_length / SMALL_AXLE), max(1.0, full_speed / SMALL_SPEED))

    def factor(self, unit: str) -> float:
        """Return by how much [1] a quantity of a unit grows."""
        mass, length, time = dimension(unit)
        by_length, by_speed = GROWTH.get(_whole(length, time), (0, 0)) if mass in (0, 1) else (0, 0)
        return float(self.length**by_length * self.speed**by_speed)

    def bounds(self, parameter: Parameter) -> tuple[float, float]:
        """Return the lowest and the highest value of a parameter; what must be positive stays as small as it may."""
        factor = self.factor(parameter.unit)
        low = parameter.low * factor if parameter.low < 0.0 else parameter.low
        return low, parameter.high * factor


SMALL = Scale()
LARGEST = Scale(length=10.0, speed=10.0)
"""An axle of 3 m, 10 m/s: robots of half a tonne are well within it."""


def _whole(length: Fraction, time: Fraction) -> tuple[int, int]:
    """Return whole powers; (0, 0), which nothing grows by, for others."""
    return (int(length), int(time)) if length.denominator == time.denominator == 1 else (0, 0)
