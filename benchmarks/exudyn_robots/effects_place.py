"""The labels' laws of load, floor, places, moments and sensing, and the physics outside the labels
(see effects.py).
"""

from __future__ import annotations

import math

from benchmarks.exudyn_robots.effects import LAWS, Draw, Law, caster_load, law, of_weight
from benchmarks.exudyn_robots.robots import Setup

OUTSIDE = "outside"


def _payload(x: Setup, size: float, d: Draw, height: float) -> dict[str, float]:
    x.body.payload = size * x.body.mass
    axle = float(x.par["axle"][0])
    loaded = [c.x for c in x.body.casters if c.gap == 0.0]
    sign = math.copysign(1.0, loaded[0]) if len(loaded) == 1 else (1.0 if d.u[0] < 0.5 else -1.0)
    x.body.payload_at = (sign * d.span(1, 0.1, 0.35) * axle, (d.u[2] - 0.5) * 0.6 * axle, height * axle)
    return {
        "mass_kg": x.body.payload,
        "x_m": x.body.payload_at[0],
        "y_m": x.body.payload_at[1],
        "z_m": x.body.payload_at[2],
    }


@law("payload_offset", "box_low", "share_of_mass", 0.03, 1.2)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    return _payload(x, size, d, 0.05)


@law("payload_offset", "box_high", "share_of_mass", 0.03, 1.0)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    return _payload(x, size, d, 0.45)


@law("floor_tilt", "plane", "rad", 0.001, 0.12)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["tilt_x"], x.par["tilt_y"] = d.towards(0, size)
    return {"tilt_rad": size, "downhill_rad": d.angle(0)}


@law("floor_tilt", "bowl", "rad_per_m", 0.001, 0.08)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["dish"] = -size if d.u[0] < 0.6 else size
    x.par["dish_x"], x.par["dish_y"] = (d.u[1] - 0.5) * x.half_area, (d.u[2] - 0.5) * x.half_area
    return {
        "slope_rad_per_m": float(x.par["dish"][0]),
        "x_m": float(x.par["dish_x"][0]),
        "y_m": float(x.par["dish_y"][0]),
    }


@law("carpet_nap", "pull", "share_of_weight", 0.001, 0.1)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["nap_pull"], x.par["nap_angle"] = size, d.angle(0)
    return {"pull_share_of_weight": size, "angle_rad": d.angle(0)}


@law("carpet_nap", "against_the_pile", "share_of_weight", 0.003, 0.2)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["nap_drag"], x.par["nap_angle"] = size, d.angle(0)
    return {"drag_share_of_weight": size, "angle_rad": d.angle(0)}


@law("carpet_nap", "carry", "share_of_way", 0.002, 0.15)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["nap_carry"], x.par["nap_angle"] = size, d.angle(0)
    return {"share_of_way": size, "angle_rad": d.angle(0)}


def _spot(x: Setup, d: Draw, name: str, low: float, high: float) -> dict[str, float]:
    """Puts a round place on one of the spots the driver likes."""
    at = d.spot(0)
    r = d.span(1, low, high)
    x.par[f"{name}_x"], x.par[f"{name}_y"], x.par[f"{name}_r"] = at[0], at[1], r
    return {"x_m": float(at[0]), "y_m": float(at[1]), "radius_m": r}


@law("rough_floor_patch", "rubber_mat", "rolling_coefficient", 0.01, 0.4, local=True)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["rough"], x.par["caster_load"] = size, caster_load(x)
    return {"rolling_coefficient": size} | _spot(x, d, "rough", 0.3, 0.65)


@law("rough_floor_patch", "gravel", "s_per_m", 0.02, 1.2, local=True)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["rough_viscous"] = size
    return {"coefficient_s_per_m": size} | _spot(x, d, "rough", 0.3, 0.65)


@law("low_friction_patch", "polished", "grip_divisor", 1.02, 80.0, local=True)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["slick"] = 1.0 - 1.0 / size
    return {"grip": float(x.par["grip"][0]) / size} | _spot(x, d, "slick", 0.35, 0.7)


@law("low_friction_patch", "wet_film", "m_per_s", 0.01, 1.5, local=True)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["slick"], x.par["slick_film"] = 0.4, size
    return {"grip": 0.6 * float(x.par["grip"][0]), "film_m_per_s": size} | _spot(x, d, "slick", 0.35, 0.7)


def _push(x: Setup, size: float, d: Draw, time: float, flat: float) -> dict[str, float]:
    x.par["push"] = of_weight(x, size)
    begin = 5.0 + (d.seconds[d.run] - 15.0) * float((d.u[0] + 0.37 * d.run) % 1.0)
    x.par["push_from"], x.par["push_time"], x.par["push_flat"] = begin, time, flat
    x.par["push_angle"] = d.angle(1)
    x.par["push_arm"] = d.span(2, -0.6, 0.6) * float(x.par["axle"][0])
    return {
        "force_n": float(x.par["push"][0]),
        "time_s": time,
        "angle_in_robot_rad": d.angle(1),
        "arm_m": float(x.par["push_arm"][0]),
    }


@law("external_push", "knock", "share_of_weight", 0.03, 1.5, local=True)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    return _push(x, size, d, d.span(3, 0.2, 0.6), 0.0)


@law("external_push", "hand", "share_of_weight", 0.02, 1.0, local=True)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    return _push(x, size, d, d.span(3, 0.8, 2.0), 1.0)


@law("observation_delay", "constant", "s", 0.005, 0.8, needs=("encoders",))
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.sensing.pose_delay = size
    return {"delay_s": size}


@law("observation_delay", "uneven", "s", 0.005, 0.8, needs=("encoders",))
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.sensing.pose_delay, x.sensing.pose_delay_swing = size, d.span(0, 0.2, 0.5)
    return {"delay_s": size, "swing_share": x.sensing.pose_delay_swing}


@law("sensor_offset", "bracket", "m", 0.002, 0.2)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    ahead, left = d.towards(0, size)
    x.sensing.tag = (x.sensing.tag[0] + ahead, x.sensing.tag[1] + left)
    return {"x_m": x.sensing.tag[0], "y_m": x.sensing.tag[1]}


@law("sensor_yaw", "turned", "rad", 0.003, 0.5)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.sensing.tag_yaw += size if d.u[0] < 0.5 else -size
    return {"yaw_rad": x.sensing.tag_yaw}


@law("clock_drift", "rate", "share", 0.0003, 0.04)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.sensing.clock_rate = size if d.u[0] < 0.5 else -size
    return {"rate": x.sensing.clock_rate}


@law("clock_drift", "warming", "share_per_minute", 0.0005, 0.04)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    sign = 1.0 if d.u[0] < 0.5 else -1.0
    x.sensing.clock_rate, x.sensing.clock_bend = 0.3 * sign * size, 0.5 * sign * size
    return {"rate_at_start": 0.3 * sign * size, "rate_after_a_minute": 1.3 * sign * size}


def _marker(x: Setup, d: Draw) -> dict[str, float]:
    at = d.spot(0)
    x.sensing.marker_x, x.sensing.marker_y = float(at[0]), float(at[1])
    x.sensing.marker_r = d.span(1, 0.4, 0.8)
    return {"x_m": float(at[0]), "y_m": float(at[1]), "radius_m": x.sensing.marker_r}


@law("misplaced_marker", "shifted", "m", 0.002, 0.25, local=True)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.sensing.marker_shift = d.towards(2, size)
    return {"shift_m": size, "angle_rad": d.angle(2)} | _marker(x, d)


@law("misplaced_marker", "turned", "rad", 0.005, 0.5, local=True)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.sensing.marker_turn = size if d.u[2] < 0.5 else -size
    x.sensing.marker_shift = d.towards(3, 0.2 * size)
    return {"turn_rad": x.sensing.marker_turn, "shift_m": 0.2 * size} | _marker(x, d)


@law(OUTSIDE, "elastic_tether", "share_of_weight_per_m", 0.001, 0.3)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["tether_k"] = of_weight(x, size)
    x.par["tether_x"], x.par["tether_y"] = d.towards(0, x.half_area)
    x.par["tether_l"] = d.span(1, 0.5, 1.2) * x.half_area
    return {"stiffness_n_per_m": float(x.par["tether_k"][0]), "slack_m": float(x.par["tether_l"][0])}


@law(OUTSIDE, "wind_jet", "share_of_weight", 0.001, 0.3)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["wind"] = of_weight(x, size)
    at = d.spot(0)
    x.par["wind_x"], x.par["wind_y"], x.par["wind_angle"] = at[0], at[1], d.angle(1)
    x.par["wind_width"] = d.span(2, 0.3, 0.6)
    return {"force_n": float(x.par["wind"][0]), "width_m": float(x.par["wind_width"][0])}


@law(OUTSIDE, "magnetic_field", "share_of_weight_times_axle", 0.003, 0.2)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["compass"] = of_weight(x, size) * x.par["axle"]
    x.par["compass_angle"] = d.angle(0)
    return {"torque_nm": float(x.par["compass"][0])}


@law(OUTSIDE, "trailer", "share_of_weight", 0.001, 0.4)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    axle = float(x.par["axle"][0])
    x.par["trailer"] = of_weight(x, size)
    x.par["trailer_l"], x.par["hitch"] = d.span(0, 1.0, 2.0) * axle, d.span(1, 0.5, 0.8) * axle
    return {"drag_n": float(x.par["trailer"][0]), "length_m": float(x.par["trailer_l"][0])}


@law(OUTSIDE, "crosstalk", "share", 0.01, 0.4)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["couple"] = size if d.u[0] < 0.5 else -size
    return {"share_of_other_command": float(x.par["couple"][0])}


@law(OUTSIDE, "sloshing_load", "share_of_mass", 0.05, 1.2)
def _(x: Setup, size: float, d: Draw) -> dict[str, float]:
    x.par["slosh"] = size * x.body.mass
    x.par["slosh_rate"], x.par["slosh_damp"] = d.span(0, 4.0, 9.0), d.span(1, 0.03, 0.12)
    return {"mass_kg": float(x.par["slosh"][0]), "rate_rad_per_s": float(x.par["slosh_rate"][0])}


GROUPS = {
    "motor": (
        "motor_deadband",
        "command_saturation",
        "motor_gain_curve",
        "motor_reverse_asymmetry",
        "motor_asymmetric_lag",
        "motor_fault",
        "battery_sag",
        "motor_warmup",
    ),
    "time": ("command_delay", "observation_delay", "clock_drift"),
    "mechanics": (
        "coulomb_friction",
        "gear_backlash",
        "wheel_eccentricity",
        "caster_drag",
        "tyre_scrub",
        "lateral_slip",
        "payload_offset",
    ),
    "floor": ("floor_tilt", "carpet_nap", "rough_floor_patch", "low_friction_patch", "external_push"),
    "sensor": ("sensor_offset", "sensor_yaw", "misplaced_marker"),
}
LABELS = tuple(sorted(label for labels in GROUPS.values() for label in labels))


def laws_of(label: str) -> list[Law]:
    """The laws of a label ("outside" for the physics without one)."""
    return [x for x in LAWS if x.label == label]


def group_of(label: str) -> str:
    """The kind of a label."""
    return next(g for g, labels in GROUPS.items() if label in labels)
