"""The labels, and the list of laws that the modules `laws_*` fill."""

from __future__ import annotations

from collections.abc import Callable

from benchmarks.robot_sets.laws import SENSED, Apply, Law

GROUPS = {
    "command": ("command_delay", "command_point", "command_saturation", "speed_controller"),
    "driver": ("motor_deadband", "motor_gain_curve", "pwm_steps", "motor_asymmetric_lag"),
    "supply": ("battery_sag", "motor_warmup"),
    "motor": ("coulomb_friction", "gear_backlash", "motor_fault", "motor_reverse_asymmetry"),
    "body": ("caster_drag", "payload_offset", "wheel_eccentricity"),
    "tyre": ("lateral_slip", "skid_steer", "tyre_scrub", "wheel_slip"),
    "floor": ("carpet_nap", "floor_tilt", "low_friction_patch", "rough_floor_patch"),
    "push": ("external_push",),
    "seen": SENSED,
}

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
        LAWS.append(Law(label, name, unit, *span, source, apply, local, needs))
        return apply

    return add
