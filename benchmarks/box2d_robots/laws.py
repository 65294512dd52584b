"""The labels, and the list of laws that the modules `laws_*` fill."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from benchmarks.box2d_robots.parts import Setup

OUTSIDE = "outside"
GROUPS = {
    "command": ("command_delay", "command_point", "command_saturation", "speed_controller"),
    "driver": ("motor_deadband", "motor_gain_curve", "pwm_steps", "motor_asymmetric_lag"),
    "supply": ("battery_sag", "motor_warmup"),
    "motor": ("coulomb_friction", "gear_backlash", "motor_fault", "motor_reverse_asymmetry"),
    "body": ("caster_drag", "payload_offset", "wheel_eccentricity"),
    "tyre": ("lateral_slip", "skid_steer", "tyre_scrub", "wheel_slip"),
    "floor": ("carpet_nap", "floor_tilt", "low_friction_patch", "rough_floor_patch"),
    "push": ("external_push",),
    "seen": ("clock_drift", "misplaced_marker", "observation_delay", "sensor_offset", "sensor_yaw"),
}
LABELS = tuple(sorted(name for names in GROUPS.values() for name in names))
SENSED = frozenset(GROUPS["seen"])  # they act on what is seen, not on the robot


@dataclass(frozen=True)
class Draw:
    """What chance gives a law: numbers in 0 to 1, a seed, two busy places [m], the shortest run [s], the
    area [m].
    """

    numbers: tuple[float, ...]
    seed: int
    spots: tuple[tuple[float, float], ...]
    seconds: float
    area: float

    def between(self, k: int, low: float, high: float) -> float:
        """Return number k between two limits."""
        return low + (high - low) * self.numbers[k]

    def sign(self, k: int) -> float:
        """Return 1 or -1 by number k."""
        return 1.0 if self.numbers[k] < 0.5 else -1.0


Apply = Callable[[Setup, float, Draw], dict[str, float]]


@dataclass(frozen=True)
class Law:
    """One way in which a label comes about; effects grow with size, which is sought between low and high.

    local : felt only at places or moments, which set `touched`; needs : duty (no controller), fork, slider.
    """

    label: str
    name: str
    apply: Apply
    low: float
    high: float
    unit: str
    source: str
    needs: tuple[str, ...]
    local: bool


LAWS: list[Law] = []


def law(
    label: str,
    name: str,
    span: tuple[float, float],
    unit: str,
    source: str,
    needs: tuple[str, ...] = (),
    local: bool = False,
) -> Callable[[Apply], Apply]:
    """Add a law to the list; what it decorates changes a setup and returns the sizes in words and units."""

    def add(apply: Apply) -> Apply:
        LAWS.append(Law(label, name, apply, *span, unit, source, needs, local))
        return apply

    return add


def laws_of(label: str) -> list[Law]:
    """Return the laws of a label."""
    return [law for law in LAWS if law.label == label]


def group_of(label: str) -> str:
    """Return the kind of a label."""
    return next(kind for kind, names in GROUPS.items() if label in names)
