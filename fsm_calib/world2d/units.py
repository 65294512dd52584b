"""Units of parameters as products of powers, such as ``N s/m`` or ``kg m2``, and what they measure."""

from __future__ import annotations

import re
from fractions import Fraction
from functools import cache

from fsm_calib.errors import UnknownNameError

Dimension = tuple[Fraction, Fraction, Fraction]
"""Exponents of mass, length and time; angles and ratios have none."""

NAMED: dict[str, tuple[int, int, int]] = {
    "1": (0, 0, 0),
    "rad": (0, 0, 0),
    "kg": (1, 0, 0),
    "m": (0, 1, 0),
    "s": (0, 0, 1),
    "Hz": (0, 0, -1),
    "N": (1, 1, -2),
    "J": (1, 2, -2),
    "W": (1, 2, -3),
}
"""The units that a product may hold: exponents of kilogram, metre and second."""

POWER = re.compile(r"([A-Za-z]+|1)(-?\d+)?$")


@cache
def dimension(unit: str) -> Dimension:
    """Return the dimension of a unit; factors are separated by spaces, one slash divides by all that follow it.

    Raises
    ------
    UnknownNameError
        For a factor that is no SI unit of mechanics; offers the nearest.
    """
    exponents = [Fraction(0)] * 3
    for sign, part in zip((1, -1), unit.split("/", 1)):
        for factor in part.split():
            match = POWER.match(factor)
            if match is None or match[1] not in NAMED:
                raise UnknownNameError("unit", factor, NAMED)
            power = sign * int(match[2] or 1)
            exponents = [e + power * n for e, n in zip(exponents, NAMED[match[1]], strict=True)]
    if not unit.strip():
        raise UnknownNameError("unit", unit, NAMED)
    return exponents[0], exponents[1], exponents[2]


def holds_mass(unit: str) -> bool:
    """Return whether a quantity scales with the robot's mass: forces, moments, impulses, dampers, masses."""
    return dimension(unit)[0] != 0


def is_length(unit: str) -> bool:
    """Return whether a quantity is a length."""
    return dimension(unit) == (0, 1, 0)


def is_time(unit: str) -> bool:
    """Return whether a quantity is a time."""
    return dimension(unit) == (0, 0, 1)
