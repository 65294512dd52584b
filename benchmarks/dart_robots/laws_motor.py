"""Effects of commands, drivers, motors, gears and the battery; each law names where it is described."""

from __future__ import annotations

import numpy as np

from benchmarks.dart_robots.law import (
    Details,
    Law,
    both_sides,
    one_side,
    shared,
    sides,
    with_drive,
    with_place,
)
from benchmarks.dart_robots.truth import Truth

DUTY = ("duty",)
RATE = ("rate",)


def _stall(truth: Truth) -> float:
    drive = truth.drive
    return float(np.mean([k * drive.volts / ohm for k, ohm in zip(drive.emf, drive.ohm)]))


def _bridge(truth: Truth, size: float, details: Details) -> Truth:
    return with_drive(truth, bridge_drop=size * truth.drive.volts)


def _weak_battery(truth: Truth, size: float, details: Details) -> Truth:
    """Lower the voltage that the controller has left; its gains and feed-forward stay in duty."""
    drive = truth.drive
    return with_drive(truth, volts=size * drive.top_rate * max(drive.emf))


def _brushes(truth: Truth, size: float, details: Details) -> Truth:
    sign = details["sign"]
    change = [1.0 + sign * size * details[f"{side}_share"] for side in ("left", "right")]
    return with_drive(truth, reverse_emf=(change[0], change[1]))


def _brush_draw(rng: np.random.Generator, truth: Truth) -> Details:
    return sides(rng, truth) | {"sign": float(rng.choice([-1.0, 1.0]))}


def _half_bridge(truth: Truth, size: float, details: Details) -> Truth:
    return with_drive(truth, reverse_drop=shared(details, size * truth.drive.volts))


def _slew(truth: Truth, size: float, details: Details) -> Truth:
    """Ramp the affected wheels; a share below 1 means a slower ramp there."""
    left, right = details["left_share"], details["right_share"]
    return with_drive(truth, slew=(size * left, size * right))


def _flywheel(truth: Truth, size: float, details: Details) -> Truth:
    rotor = truth.drive.rotor
    added = shared(details, size)
    return with_drive(truth, rotor=(rotor[0] * (1 + added[0]), rotor[1] * (1 + added[1])))


def _fault(kind: str) -> Law:
    weak, strong = {"thermal_cutback": (0.05, 0.8), "loose_contact": (0.1, 0.9), "jam": (0.03, 0.6)}[kind]
    unit = {
        "thermal_cutback": "duty_lost_share",
        "loose_contact": "open_share",
        "jam": "friction_stall_share",
    }
    return Law(
        "motor_fault",
        kind,
        unit[kind],
        weak,
        strong,
        lambda truth, size, details: with_place(
            truth, fault=kind, fault_size=size, fault_side=int(details["right_share"])
        ),
        one_side,
        DUTY,
        "fault",
    )


def _tight(truth: Truth, size: float, details: Details) -> Truth:
    left, right = shared(details, size * _stall(truth))
    return with_drive(truth, dry=(truth.drive.dry[0] + left, truth.drive.dry[1] + right))


def _stribeck(truth: Truth, size: float, details: Details) -> Truth:
    rate = details["stribeck_rate_share"] * truth.drive.top_rate
    ratio = details["static_to_kinetic"]
    return with_drive(_tight(truth, size, details), static_ratio=ratio, stribeck_rate=rate)


def _stribeck_draw(rng: np.random.Generator, truth: Truth) -> Details:
    return both_sides(rng, truth) | {
        "stribeck_rate_share": float(rng.uniform(0.04, 0.12)),
        "static_to_kinetic": float(rng.uniform(1.3, 1.8)),
    }


def _cell_ohm(truth: Truth, size: float, details: Details) -> Truth:
    return with_drive(truth, cell_ohm=size * float(np.mean(truth.drive.ohm)))


def _old_cells(truth: Truth, size: float, details: Details) -> Truth:
    return with_drive(_cell_ohm(truth, size, details), discharge=0.5 * size)


def _grease(truth: Truth, size: float, details: Details) -> Truth:
    per_rate = size * _stall(truth) / truth.drive.top_rate
    return with_drive(truth, grease=shared(details, per_rate), grease_time=details["warming_time_s"])


def _grease_draw(rng: np.random.Generator, truth: Truth) -> Details:
    return sides(rng, truth) | {"warming_time_s": float(rng.uniform(12.0, 30.0))}


def _windings(truth: Truth, size: float, details: Details) -> Truth:
    drive = truth.drive
    ohm = float(np.mean(drive.ohm))
    watt = (0.2 * drive.volts) ** 2 / ohm  # at a fifth of the stall current
    return with_drive(truth, heat=size, heat_watt=watt, heat_time=details["warming_time_s"])


def _windings_draw(rng: np.random.Generator, truth: Truth) -> Details:
    return {"warming_time_s": float(rng.uniform(15.0, 35.0))}


LAWS = (
    Law("motor_deadband", "driver_threshold", "minimum_duty", 0.02, 0.4,
        lambda t, size, d: with_drive(t, deadzone=size), modes=DUTY),
    Law("motor_deadband", "bridge_drop", "drop_share_of_supply", 0.02, 0.4, _bridge, modes=DUTY),
    Law("motor_deadband", "setpoint_deadzone", "deadzone_share_of_top_rate", 0.02, 0.4,
        lambda t, size, d: with_drive(t, deadzone=size), modes=RATE),
    Law("command_saturation", "duty_ceiling", "ceiling_duty", 0.95, 0.25,
        lambda t, size, d: with_drive(t, ceiling=size), modes=DUTY),
    Law("command_saturation", "speed_ceiling", "ceiling_share_of_top_rate", 0.95, 0.25,
        lambda t, size, d: with_drive(t, ceiling=size), modes=RATE),
    Law("command_saturation", "weak_battery", "free_rate_share_of_top_rate", 1.1, 0.35, _weak_battery,
        modes=RATE),
    Law("motor_gain_curve", "coasting_pwm", "coasting_share_of_off_time", 0.03, 0.95,
        lambda t, size, d: with_drive(t, coast=shared(d, size)), sides, DUTY),
    Law("motor_gain_curve", "exponential_stick", "cubic_share", 0.03, 0.95,
        lambda t, size, d: with_drive(t, expo=shared(d, size)), sides),
    Law("motor_reverse_asymmetry", "brush_timing", "change_of_emf_share", 0.01, 0.35, _brushes,
        _brush_draw, DUTY),
    Law("motor_reverse_asymmetry", "weak_half_bridge", "drop_share_of_supply", 0.01, 0.35, _half_bridge,
        one_side,
        DUTY),
    Law("motor_asymmetric_lag", "soft_start", "ramp_per_s", 25.0, 0.35, _slew, one_side),
    Law("motor_asymmetric_lag", "input_filter", "time_constant_s", 0.008, 0.8,
        lambda t, size, d: with_drive(t, lowpass=shared(d, size)), sides),
    Law("motor_asymmetric_lag", "flywheel", "added_inertia_in_rotors", 0.1, 10.0, _flywheel, one_side, DUTY),
    _fault("thermal_cutback"),
    _fault("loose_contact"),
    _fault("jam"),
    Law("command_delay", "transport", "delay_s", 0.02, 0.6, lambda t, size, d: with_drive(t, delay=size),
        encoders=True),
    Law("command_delay", "wireless_jitter", "mean_delay_s", 0.02, 0.6,
        lambda t, size, d: with_drive(t, delay=0.75 * size, jitter=0.25 * size), encoders=True),
    Law("coulomb_friction", "tight_gears", "friction_stall_share", 0.03, 0.5, _tight, both_sides, DUTY),
    Law("coulomb_friction", "stribeck_gears", "friction_stall_share", 0.03, 0.35, _stribeck,
        _stribeck_draw, DUTY),
    Law("gear_backlash", "worn_gears", "play_rad", 0.01, 0.3,
        lambda t, size, d: with_drive(t, backlash=shared(d, size)), both_sides,
        caster="ball", kinds=("duckiebot", "burger")),
    Law("battery_sag", "cell_resistance", "resistance_share_of_motor", 0.03, 0.8, _cell_ohm, modes=DUTY),
    Law("battery_sag", "discharge", "voltage_lost_share", 0.02, 0.5,
        lambda t, size, d: with_drive(t, discharge=size), modes=DUTY),
    Law("battery_sag", "old_cells", "resistance_share_of_motor", 0.03, 0.6, _old_cells, modes=DUTY),
    Law("motor_warmup", "thinning_grease", "drag_stall_share_at_top_rate", 0.03, 1.2, _grease,
        _grease_draw, DUTY),
    Law("motor_warmup", "hot_windings", "rise_at_fifth_of_stall_current_k", 5.0, 300.0, _windings,
        _windings_draw,
        DUTY),
)  # fmt: skip
