"""The table of laws: each hides one effect of one size in a robot."""

from __future__ import annotations

from collections.abc import Callable

from benchmarks.robot_sets.laws import SENSED, Apply, Law

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
    "sensing": SENSED,
}  # fmt: skip

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
