"""The table of laws: each hides one effect of one size in a robot."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from benchmarks.ode_robots.setup import Setup

OUTSIDE = "outside"
GROUPS = {
    "command": (
        "command_delay", "command_saturation", "motor_deadband", "motor_gain_curve", "motor_asymmetric_lag",
    ),
    "motor": (
        "battery_sag", "coulomb_friction", "gear_backlash", "motor_fault", "motor_reverse_asymmetry",
        "motor_warmup",
    ),
    "floor": ("carpet_nap", "external_push", "floor_tilt", "low_friction_patch", "rough_floor_patch"),
    "body": ("caster_drag", "lateral_slip", "payload_offset", "tyre_scrub", "wheel_eccentricity"),
    "sensing": ("clock_drift", "misplaced_marker", "observation_delay", "sensor_offset", "sensor_yaw"),
}  # fmt: skip
LABELS = tuple(sorted(name for names in GROUPS.values() for name in names))
SENSED = frozenset(GROUPS["sensing"])


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


Apply = Callable[[Setup, float, Draw], dict[str, float]]


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


TABLE: list[Law] = []


def law(
    label: str,
    unit: str,
    low: float,
    high: float,
    source: str,
    local: bool = False,
    needs: tuple[str, ...] = (),
) -> Callable[[Apply], Apply]:
    """Add a function to the table, by its own name."""

    def add(apply: Apply) -> Apply:
        name = getattr(apply, "__name__", "law")
        TABLE.append(Law(label, name, unit, low, high, source, apply, local, needs))
        return apply

    return add


def laws_of(label: str) -> list[Law]:
    """Return the laws of a label."""
    return [one for one in TABLE if one.label == label]


def group_of(label: str) -> str:
    """Return the kind of a label."""
    return next(kind for kind, names in GROUPS.items() if label in names)
