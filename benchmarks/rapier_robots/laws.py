"""What a law of an effect is, and the list of all laws."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.rapier_robots.setup import Setup

OUTSIDE = "outside"
GROUPS = {
    "command": (
        "command_saturation",
        "motor_deadband",
        "motor_gain_curve",
        "motor_reverse_asymmetry",
        "motor_asymmetric_lag",
    ),
    "time": ("command_delay", "observation_delay", "clock_drift"),
    "motor": ("motor_fault", "battery_sag", "motor_warmup", "coulomb_friction"),
    "body": ("gear_backlash", "wheel_eccentricity", "caster_drag", "payload_offset"),
    "tyre": ("tyre_scrub", "lateral_slip", "low_friction_patch"),
    "floor": ("floor_tilt", "carpet_nap", "rough_floor_patch", "external_push"),
    "sensing": ("sensor_offset", "sensor_yaw", "misplaced_marker"),
}
LABELS = tuple(sorted(name for names in GROUPS.values() for name in names))


@dataclass(frozen=True)
class Draw:
    """What chance decided of one effect: numbers in [0, 1), a seed for each run, spots on the way, length [s].

    spots : places [m] that the robot passes often; area [m]: radius of the drive.
    """

    numbers: tuple[float, ...]
    seed: int
    spots: tuple[tuple[float, float], ...]
    seconds: float
    area: float

    def __getitem__(self, n: int) -> float:
        """Return number n."""
        return self.numbers[n]

    def between(self, n: int, low: float, high: float) -> float:
        """Return number n spread over a range."""
        return low + (high - low) * self.numbers[n]

    def sign(self, n: int) -> float:
        """Return -1 or 1 by number n."""
        return 1.0 if self.numbers[n] < 0.5 else -1.0

    def side(self, n: int) -> int:
        """Return a wheel by number n: 0 left, 1 right."""
        return 0 if self.numbers[n] < 0.5 else 1

    def angle(self, n: int) -> float:
        """Return a direction by number n [rad]."""
        return 2.0 * math.pi * self.numbers[n]

    def rng(self, run: int) -> np.random.Generator:
        """Return the generator of one run."""
        return np.random.default_rng([self.seed, run])


Apply = Callable[[Setup, float, Draw], dict[str, float]]


@dataclass(frozen=True)
class Law:
    """One physical form of an effect.

    unit of its size; low, high : sizes that are searched; local : bound to places or moments; needs : "duty",
    "speed", "ball", "fork", "encoders"; source : one line; apply changes a setup and returns the sizes for the key.
    """

    label: str
    name: str
    unit: str
    low: float
    high: float
    source: str
    apply: Apply
    local: bool = False
    needs: frozenset[str] = frozenset()


LAWS: list[Law] = []


def law(
    label: str, unit: str, low: float, high: float, source: str, local: bool = False, needs: str = ""
) -> Callable[[Apply], Apply]:
    """Add the decorated function to the laws; its name is the law's."""

    def add(apply: Apply) -> Apply:
        name = getattr(apply, "__name__", label)
        LAWS.append(Law(label, name, unit, low, high, source, apply, local, frozenset(needs.split())))
        return apply

    return add


def group_of(label: str) -> str:
    """Return the kind of a label."""
    return next((name for name, labels in GROUPS.items() if label in labels), OUTSIDE)


def laws_of(label: str) -> list[Law]:
    """Return all laws of a label."""
    return [item for item in LAWS if item.label == label]
