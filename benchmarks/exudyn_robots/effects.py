"""The labels' laws that act in the drive, wheels, and casters. Each changes a copy of a robot's
setup by a size.

A law has a name, the unit of its size and the sensible range of sizes; `draw.u` are uniforms drawn
once for the robot
(so that only the size changes in the search) and `draw.run` the run's number. It returns the sizes
for the key.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.exudyn_robots.physics import G
from benchmarks.exudyn_robots.robots import Setup


@dataclass
class Draw:
    """What an effect drew besides its size: uniforms, the run's number, places the driver likes, run
    lengths s.
    """

    u: np.ndarray
    spots: np.ndarray
    seconds: list[float]
    run: int = 0

    def span(self, k: int, low: float, high: float) -> float:
        """Uniform k scaled to low..high."""
        return float(low + (high - low) * self.u[k])

    def angle(self, k: int) -> float:
        """Uniform k as a direction, rad."""
        return float(2.0 * math.pi * self.u[k] - math.pi)

    def towards(self, k: int, length: float) -> tuple[float, float]:
        """A vector of this length in the direction of uniform k."""
        return length * math.cos(self.angle(k)), length * math.sin(self.angle(k))

    def spot(self, k: int) -> np.ndarray:
        """One of the places the driver likes, m."""
        return self.spots[int(len(self.spots) * self.u[k])]

    def sides(self, k: int) -> np.ndarray:
        """Both wheels alike, unlike, or one only."""
        if self.u[k] < 0.5:
            return (
                np.array([1.0, 0.5 + self.u[k + 1]])
                if self.u[k] < 0.25
                else np.array([0.5 + self.u[k + 1], 1.0])
            )
        if self.u[k] < 0.75:
            return np.array([1.0, 1.0])
        return np.array([1.0, 0.0]) if self.u[k + 1] < 0.5 else np.array([0.0, 1.0])


Apply = Callable[[Setup, float, Draw], dict[str, float]]


@dataclass(frozen=True)
class Law:
    """A law of a label: range of sizes, whether it acts in a place or moment, which robots it needs."""

    label: str
    name: str
    unit: str
    low: float
    high: float
    apply: Apply
    local: bool = False
    needs: tuple[str, ...] = ()


LAWS: list[Law] = []


def both(x: Setup, name: str, unit: str) -> dict[str, float]:
    """What a parameter of both wheels is, for the key."""
    left, right = x.par[name][0]
    return {f"left_{unit}": float(left), f"right_{unit}": float(right)}


def of_weight(x: Setup, share: float) -> float:
    """A share of the robot's weight, N."""
    return share * x.body.mass * G


def caster_load(x: Setup) -> float:
    """What a caster bears, N."""
    return of_weight(x, 0.15)


def law(
    label: str,
    name: str,
    unit: str,
    low: float,
    high: float,
    local: bool = False,
    needs: tuple[str, ...] = (),
) -> Callable[[Apply], Apply]:
    """Registers a law."""

    def keep(f: Apply) -> Apply:
        LAWS.append(Law(label, name, unit, low, high, f, local, needs))
        return f

    return keep


@law("motor_deadband", "cut_out", "command", 0.01, 0.45)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["dead"] = np.minimum(size * np.maximum(d.sides(0), 0.5), 0.6)
    return both(x, "dead", "command")


@law("motor_deadband", "subtracted", "command", 0.01, 0.35)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["dead"] = np.minimum(size * np.maximum(d.sides(0), 0.5), 0.5)
    x.par["dead_subtract"] = 1.0
    return both(x, "dead", "command")


@law("command_saturation", "clipped", "share_lost", 0.05, 0.75)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["limit"] = 1.0 - size
    return {"limit_command": 1.0 - size}


@law("command_saturation", "knee", "per_command", 0.3, 3.5)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["limit_soft"] = size
    return {"knee_command": 1.0 / size}


@law("motor_gain_curve", "power", "exponent_minus_1", 0.03, 1.5)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["curve_power"] = 1.0 + size if d.u[0] < 0.5 else 1.0 / (1.0 + size)
    return {"exponent": float(x.par["curve_power"][0])}


@law("motor_gain_curve", "bridge", "bend", 0.05, 6.0)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["curve_bridge"] = size
    return {"bend": size}


@law("motor_reverse_asymmetry", "firmware", "share_lost", 0.01, 0.6)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["reverse"] = 1.0 - size * np.minimum(d.sides(0), 1.2)
    return both(x, "reverse", "share")


@law("motor_reverse_asymmetry", "brush_timing", "share_lost", 0.01, 0.5, needs=("duty",))
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["reverse_brush"] = 1.0 - size * np.minimum(d.sides(0), 1.2)
    return both(x, "reverse_brush", "free_share")


@law("motor_asymmetric_lag", "first_order", "s", 0.02, 1.5)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["lag"] = size * d.sides(0)
    return both(x, "lag", "s")


@law("motor_asymmetric_lag", "slew", "s_to_full", 0.03, 5.0)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["slew"] = 1.0 / (size * np.maximum(d.sides(0), 0.05))
    return both(x, "slew", "per_s")


def _fault(x: Setup, size: float, d: Draw) -> None:
    n = 3 + int(3.0 * d.u[0])
    rng = np.random.default_rng(int(1e9 * d.u[1]) + d.run)
    gap = (d.seconds[d.run] - 6.0) / n
    begin = 4.0 + gap * (np.arange(n) + 0.6 * rng.random(n))
    x.par["fault_side"] = int(d.u[2] < 0.5)
    x.par["fault_loss"] = size
    x.par["fault_from"][0, :n] = begin
    x.par["fault_to"][0, :n] = begin + rng.uniform(1.5, 0.35 * gap + 1.0, n)


@law("motor_fault", "weak", "share_lost", 0.04, 1.0, local=True)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    _fault(x, size, d)
    return {"share_lost": size}


@law("motor_fault", "loose_contact", "share_lost", 0.08, 1.0, local=True)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    _fault(x, size, d)
    x.par["fault_chop"] = d.span(3, 0.08, 0.3)
    return {"share_lost": size, "period_s": float(x.par["fault_chop"][0])}


@law("command_delay", "constant", "s", 0.02, 0.8, needs=("encoders",))
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.command_delay = size
    return {"delay_s": size}


@law("command_delay", "polled", "s", 0.02, 0.8, needs=("encoders",))
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.command_delay, x.command_poll = 0.75 * size, 0.5 * size
    return {"least_s": 0.75 * size, "most_s": 1.25 * size}


@law("battery_sag", "old_cells", "share_at_stall", 0.03, 0.8, needs=("duty",))
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["battery_r"] = size
    return {"resistance_share_of_motor": size}


@law("battery_sag", "discharge", "share_per_minute", 0.01, 0.5, needs=("duty",))
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["battery_fall"] = size / 60.0
    return {"fall_per_minute": size}


@law("battery_sag", "polarisation", "share_at_stall", 0.05, 1.5, needs=("duty",))
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["battery_pol"], x.par["battery_tau"] = size, d.span(0, 4.0, 15.0)
    return {"resistance_share_of_motor": size, "time_s": float(x.par["battery_tau"][0])}


@law("motor_warmup", "winding", "share_of_resistance", 0.05, 2.5, needs=("duty",))
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["heat"], x.par["heat_tau"] = size, d.span(0, 10.0, 30.0)
    return {"rise_at_fifth_of_stall": size, "time_s": float(x.par["heat_tau"][0])}


@law("motor_warmup", "magnet", "share_of_speed", 0.01, 0.3, needs=("duty",))
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["magnet"], x.par["magnet_tau"] = size, d.span(0, 10.0, 35.0)
    return {"free_rate_rise": size, "time_s": float(x.par["magnet_tau"][0])}


@law("motor_warmup", "cold_grease", "times_friction", 0.3, 12.0, needs=("duty",))
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    for name in ("viscous", "dry"):
        x.par[name] *= 1.0 + size
    x.par["grease"], x.par["grease_tau"] = size / (1.0 + size), d.span(0, 8.0, 25.0)
    return {"cold_times_warm": 1.0 + size, "time_s": float(x.par["grease_tau"][0])}


@law("coulomb_friction", "bearings", "share_of_stall", 0.02, 0.5)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["dry"] += size * x.par["stall"] * np.maximum(d.sides(0), 0.4)
    return both(x, "dry", "nm")


@law("coulomb_friction", "stribeck", "share_of_stall", 0.02, 0.4)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["dry"] += size * x.par["stall"] * np.maximum(d.sides(0), 0.4)
    x.par["static_extra"] = d.span(2, 0.3, 0.8)
    x.par["static_rate"] = d.span(3, 0.05, 0.15) * x.par["free"].mean()
    return both(x, "dry", "nm") | {"static_share_more": float(x.par["static_extra"][0])}


@law("coulomb_friction", "gear_mesh", "share_of_torque", 0.1, 0.8)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["mesh"] = size
    x.par["dry"] += 0.25 * size * x.par["stall"]
    return {"mesh_share": size} | both(x, "dry", "nm")


def _play(x: Setup, size: float, d: Draw, at_wheel: float) -> dict[str, float]:
    x.par["play_on"], x.par["encoder_at_wheel"] = 1.0, at_wheel
    x.par["play"] = size * d.sides(0)
    return both(x, "play", "rad")


@law("gear_backlash", "gear", "rad", 0.003, 0.6)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    return _play(x, size, d, 1.0)


@law("gear_backlash", "loose_hub", "rad", 0.003, 0.6)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    return _play(x, size, d, 0.0)


@law("wheel_eccentricity", "off_centre", "share_of_radius", 0.004, 0.2)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["off_centre"] = size * x.par["radius"] * d.sides(0)
    x.par["off_phase"] = [d.angle(2), d.angle(3)]
    return both(x, "off_centre", "m")


@law("wheel_eccentricity", "oval", "share_of_radius", 0.004, 0.2)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["oval"] = size * x.par["radius"] * d.sides(0)
    x.par["off_phase"] = [d.angle(2), d.angle(3)]
    return both(x, "oval", "m")


@law("caster_drag", "brake", "coefficient", 0.03, 0.9)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    for c in x.body.casters:
        if c.gap == 0.0:
            c.mu += size
            c.axle_friction += size * caster_load(x) * c.radius
    return {"coefficient_more": size}


@law("caster_drag", "stiff_swivel", "coefficient", 0.05, 3.0, needs=("swivel",))
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    for c in x.body.casters:
        if c.gap == 0.0:
            c.pivot_friction += size * caster_load(x) * c.trail
    return {"pivot_coefficient": size}


@law("caster_drag", "sticks", "coefficient", 0.05, 1.2, needs=("ball",))
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["caster_stick"], x.par["caster_load"] = size, caster_load(x)
    x.par["caster_stick_period"], x.par["caster_stick_share"] = d.span(0, 0.2, 0.8), d.span(1, 0.3, 0.6)
    return {
        "coefficient": size,
        "period_m": float(x.par["caster_stick_period"][0]),
        "share": float(x.par["caster_stick_share"][0]),
    }


@law("tyre_scrub", "wide_tyre", "width_share_of_axle", 0.03, 0.8)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["scrub_width"], x.par["scrub_grip"] = size * x.par["axle"], x.par["grip"]
    return {"width_m": float(x.par["scrub_width"][0])}


@law("tyre_scrub", "soft_tyre", "s", 0.002, 0.15)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["scrub_viscous"] = size * x.par["axle"]
    return {"nm_s_per_n": float(x.par["scrub_viscous"][0])}


@law("lateral_slip", "creep", "slip_at_full_grip", 0.02, 1.2)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["creep"] = size
    return {"slip_at_full_grip": size}


@law("lateral_slip", "weak_side", "grip_divisor", 2.0, 150.0)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["grip_side"] = 1.0 / size
    return {"side_grip": float(x.par["grip"][0]) / size}
