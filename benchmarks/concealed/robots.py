"""Which physics a concealed robot hides, how strong, and how its poses are measured."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from concealed.physics import Physics

Change = dict[str, float]


@dataclass(frozen=True)
class Hidden:
    """One hidden effect: `physics` and `sensor` map a size in (0, 1] to parameters."""

    name: str
    physics: Callable[[float, np.random.Generator], Change] = lambda s, g: {}
    sensor: Callable[[float, np.random.Generator], Change] = lambda s, g: {}
    place: bool = False
    once: bool = False


def _wheel(g: np.random.Generator, name: str, value: float) -> Change:
    return {f"{name}_{g.choice(['left', 'right'])}": value}


def _place(g: np.random.Generator, prefix: str) -> Change:
    return {f"{prefix}_x": g.uniform(-0.3, 0.3), f"{prefix}_y": g.uniform(-0.3, 0.3)}


def _tilt(s: float, g: np.random.Generator) -> Change:
    a = g.uniform(-math.pi, math.pi)
    return {"tilt_x": 0.09 * s * math.cos(a), "tilt_y": 0.09 * s * math.sin(a)}


def _push(s: float, g: np.random.Generator) -> Change:
    a = g.uniform(-math.pi, math.pi)
    return {
        "push_time": g.uniform(8, 50),
        "push_fx": 8 * s * math.cos(a),
        "push_fy": 8 * s * math.sin(a),
        "push_m": g.choice([-1, 1]) * 0.5 * s,
    }


def _fault(s: float, g: np.random.Generator) -> Change:
    start = g.uniform(8, 40)
    return {**_wheel(g, "fault", 0.8 * s), "fault_start": start, "fault_end": start + g.uniform(4, 14)}


def _offset(s: float, g: np.random.Generator) -> Change:
    a = g.uniform(-math.pi, math.pi)
    return {"dx": 0.08 * s * math.cos(a), "dy": 0.08 * s * math.sin(a)}


def _sign(g: np.random.Generator) -> float:
    return float(g.choice([-1.0, 1.0]))


HIDDEN = (
    Hidden("motor_deadband", lambda s, g: {"deadband": _sign(g) * 0.10 * s}),
    Hidden("command_saturation", lambda s, g: {"saturation": 0.47 - 0.30 * s}),
    Hidden("motor_gain_curve", lambda s, g: {"curve": _sign(g) * 0.9 * s}),
    Hidden(
        "motor_reverse_asymmetry",
        lambda s, g: (lambda v: {"reverse_left": v, "reverse_right": v})(_sign(g) * 0.3 * s),
    ),
    Hidden("motor_asymmetric_lag", lambda s, g: {"brake_fade": 0.9 * s}),
    Hidden("coulomb_friction", lambda s, g: {"coulomb_left": 0.05 * s, "coulomb_right": 0.05 * s}),
    Hidden("gear_backlash", lambda s, g: {"play": 0.35 * s}),
    Hidden("battery_sag", lambda s, g: {"sag_charge": 0.012 * s}),
    Hidden(
        "motor_warmup", lambda s, g: {**_wheel(g, "warm", _sign(g) * 0.3 * s), "warm_time": g.uniform(12, 35)}
    ),
    Hidden("motor_fault", _fault, once=True),
    Hidden("command_delay", lambda s, g: {"delay": 0.25 * s}),
    Hidden(
        "wheel_eccentricity",
        lambda s, g: (lambda w: {f"ecc_{w}": 0.15 * s, f"phase_{w}": g.uniform(0, 6.28)})(
            g.choice(["left", "right"])
        ),
    ),
    Hidden("caster_drag", lambda s, g: {"caster_drag": 1.2 * s, "caster_scrub": 1.2 * s}),
    Hidden("tyre_scrub", lambda s, g: {"scrub_dry": 0.06 * s}),
    Hidden("lateral_slip", lambda s, g: {"lateral_soft": 0.98 * s**0.25}),
    Hidden(
        "payload_offset",
        lambda s, g: (
            lambda a: {
                "com_x": 0.05 * s * math.cos(a),
                "com_y": 0.05 * s * math.sin(a),
                "mass": 1.1 + 0.9 * s,
                "inertia": 0.0065 + 0.005 * s,
            }
        )(g.uniform(-3.14, 3.14)),
    ),
    Hidden("floor_tilt", _tilt),
    Hidden("carpet_nap", lambda s, g: {"nap": 3.0 * s, "nap_direction": g.uniform(-3.14, 3.14)}),
    Hidden(
        "rough_floor_patch",
        lambda s, g: {**_place(g, "patch"), "patch_r": g.uniform(0.18, 0.32), "patch_drag": 3.0 * s},
        place=True,
    ),
    Hidden(
        "low_friction_patch",
        lambda s, g: {
            **_place(g, "patch"),
            "patch_r": g.uniform(0.18, 0.32),
            "patch_mu": 1.0 - 0.98 * s**0.15,
        },
        place=True,
    ),
    Hidden("external_push", _push, once=True),
    Hidden("observation_delay", sensor=lambda s, g: {"delay": 0.25 * s}),
    Hidden("sensor_offset", sensor=_offset),
    Hidden("sensor_yaw", sensor=lambda s, g: {"yaw": _sign(g) * 0.3 * s}),
    Hidden("clock_drift", sensor=lambda s, g: {"drift": 0.012 * s}),
    Hidden(
        "misplaced_marker",
        sensor=lambda s, g: {**_place(g, "mark"), "mark_r": g.uniform(0.2, 0.32), "mark": _sign(g) * 0.5 * s},
        place=True,
    ),
)
OUTSIDE = (
    Hidden("x:tether", lambda s, g: {"tether_k": 4.0 * s, **_place(g, "tether")}),
    Hidden("x:bowl", lambda s, g: {"bowl_k": -1.5 * s, **_place(g, "bowl")}),
    Hidden(
        "x:gust",
        lambda s, g: {"gust_f": 1.2 * s, "gust_period": g.uniform(3, 9), "gust_phase": g.uniform(0, 6.28)},
    ),
    Hidden("x:cross_talk", lambda s, g: {"cross_talk": _sign(g) * 0.4 * s}),
    Hidden("x:cable_twist", lambda s, g: {"twist_k": 0.02 * s}),
    Hidden("x:heading_gain", lambda s, g: {"heading_gain": 0.3 * s, "heading_phase": g.uniform(0, 6.28)}),
)
BY_NAME = {hidden.name: hidden for hidden in HIDDEN + OUTSIDE}
PAIRS = (
    ("floor_tilt", "command_delay"),
    ("motor_deadband", "sensor_offset"),
    ("coulomb_friction", "battery_sag"),
    ("payload_offset", "motor_reverse_asymmetry"),
    ("wheel_eccentricity", "floor_tilt"),
    ("rough_floor_patch", "motor_warmup"),
    ("sensor_yaw", "motor_gain_curve"),
    ("command_delay", "motor_deadband"),
    ("caster_drag", "clock_drift"),
    ("tyre_scrub", "sensor_offset"),
)


@dataclass(frozen=True)
class Sensor:
    """How poses and wheel angles are measured, and what is wrong with that."""

    rate: float = 20.0
    sigma_xy: float = 0.003
    sigma_theta: float = 0.009
    colour: float = 0.0
    outliers: float = 0.005
    dropouts: float = 0.03
    encoders: bool = False
    effect: Change = field(default_factory=dict)


ROTOR_INERTIA = (1.3e-4, 3.9e-4)
"""kg m2 at the wheel: rotors of 130-size motors, 6 g within 7 mm (1.2e-7 kg m2), behind 48:1 gears, by half either way."""


def draw_base(g: np.random.Generator) -> Physics:
    """A plain robot from the fleet: unequal gains, its own motors, tyres, axle and random disturbance."""
    return Physics()._replace(
        gain_left=g.uniform(0.88, 1.12),
        gain_right=g.uniform(0.88, 1.12),
        stall=g.uniform(0.17, 0.26),
        no_load=g.uniform(18, 23),
        mu=g.uniform(0.6, 0.9),
        stiffness=g.uniform(10, 18),
        axle=g.uniform(0.097, 0.106),
        mass=g.uniform(1.0, 1.25),
        inertia=g.uniform(0.0055, 0.0078),
        ou_force=g.uniform(0.006, 0.06),
        ou_moment=g.uniform(0.0003, 0.003),
        ou_tau=g.uniform(0.12, 0.7),
        rotor_inertia=g.uniform(*ROTOR_INERTIA),
    )


def draw_sensor(g: np.random.Generator) -> Sensor:
    """A tag tracker: rate, noise, colour, outliers and dropouts differ from robot to robot."""
    sigma = g.uniform(0.0015, 0.0045)
    return Sensor(
        rate=float(g.choice([12.0, 15.0, 20.0, 30.0])),
        sigma_xy=sigma,
        sigma_theta=3.0 * sigma,
        colour=float(g.choice([0.0, 0.0, 0.3, 0.5])),
        outliers=g.uniform(0.0, 0.02),
        dropouts=g.uniform(0.01, 0.06),
        encoders=bool(g.random() < 0.5),
    )


def observe(times: np.ndarray, states: np.ndarray, stamps: np.ndarray, effect: Change) -> np.ndarray:
    """Noise-free measured poses (n, 3) at true times `stamps` [s], with what is wrong with the sensor."""
    t = stamps - effect.get("delay", 0.0)
    pose = np.stack([np.interp(t, times, states[:, i]) for i in range(3)], 1)
    c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    dx, dy = effect.get("dx", 0.0), effect.get("dy", 0.0)
    x, y, th = pose[:, 0] + c * dx - s * dy, pose[:, 1] + s * dx + c * dy, pose[:, 2] + effect.get("yaw", 0.0)
    if "mark" in effect:
        inside = np.hypot(x - effect["mark_x"], y - effect["mark_y"]) < effect["mark_r"]
        a = effect["mark"] * inside
        rx, ry = x - effect["mark_x"], y - effect["mark_y"]
        x = effect["mark_x"] + np.cos(a) * rx - np.sin(a) * ry
        y = effect["mark_y"] + np.sin(a) * rx + np.cos(a) * ry
        th = th + a
    return np.stack([x, y, th], 1)
