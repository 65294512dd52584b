"""Effects of wheels, tyres, casters, loads, floors and people; each law names where it is described."""

from __future__ import annotations

import numpy as np

from benchmarks.dart_robots.law import (
    Details,
    Law,
    heading,
    shared,
    sides,
    with_body,
    with_drive,
    with_place,
    with_watch,
)
from benchmarks.dart_robots.truth import Patch, Truth, loads, total_mass


def _off_centre(truth: Truth, size: float, details: Details) -> Truth:
    radius = truth.body.radius
    left, right = shared(details, size)
    phase = (details["left_phase_rad"], details["right_phase_rad"])
    return with_body(truth, hub_offset=(left * radius[0], right * radius[1]), phase=phase)


def _oval(truth: Truth, size: float, details: Details) -> Truth:
    phase = (details["left_phase_rad"], details["right_phase_rad"])
    return with_body(truth, oval=shared(details, size), phase=phase)


def _phases(rng: np.random.Generator, truth: Truth) -> Details:
    turn = {f"{side}_phase_rad": float(rng.uniform(0, 2 * np.pi)) for side in ("left", "right")}
    return sides(rng, truth) | turn


def _hair(truth: Truth, size: float, details: Details) -> Truth:
    """Clog the caster: its wheel drags as the coefficient says, and its fork turns badly."""
    torque = size * loads(truth.body)[2] * truth.body.caster_radius
    return with_body(truth, caster_axle_torque=torque, swivel_torque=0.4 * torque)


def _side_load(truth: Truth, size: float, details: Details) -> Truth:
    body = truth.body
    at = (
        0.3 * body.centre[0],
        details["side"] * details["share_of_half_axle"] * body.axle / 2,
        body.radius[0],
    )
    return with_body(truth, payload=size * total_mass(body), payload_at=at)


def _tail_load(truth: Truth, size: float, details: Details) -> Truth:
    body = truth.body
    at = (details["share_of_caster_arm"] * body.caster_arm, 0.1 * details["side"] * body.axle, body.radius[0])
    return with_body(truth, payload=size * total_mass(body), payload_at=at)


def _load_draw(rng: np.random.Generator, truth: Truth) -> Details:
    return {
        "side": float(rng.choice([-1.0, 1.0])),
        "share_of_half_axle": float(rng.uniform(0.7, 1.0)),
        "share_of_caster_arm": float(rng.uniform(0.7, 1.1)),
    }


def _rough(truth: Truth, size: float, details: Details) -> Truth:
    patch = Patch(details["x_m"], details["y_m"], details["radius_m"], rolling=size)
    return with_place(truth, rough=patch)


def _slippery(truth: Truth, size: float, details: Details) -> Truth:
    patch = Patch(details["x_m"], details["y_m"], details["radius_m"], grip=size)
    return with_place(truth, slippery=patch)


def _patch_draw(rng: np.random.Generator, truth: Truth) -> Details:
    # the middle is set to the driver's spot, off by this much
    return {
        "x_m": float(rng.normal(0, 0.05)),
        "y_m": float(rng.normal(0, 0.05)),
        "radius_m": float(rng.uniform(0.16, 0.26)),
    }


def _push(truth: Truth, size: float, details: Details) -> Truth:
    body = truth.body
    at = (details["at_x_share"] * abs(body.caster_arm), details["at_y_share"] * body.axle / 2)
    return with_place(
        truth,
        push=size * total_mass(body) * 9.81,
        push_time=details["push_time_s"],
        push_heading=details["heading_rad"],
        push_at=at,
    )


def _push_draw(rng: np.random.Generator, truth: Truth) -> Details:
    return heading(rng, truth) | {
        "push_time_s": float(rng.uniform(0.15, 0.45)),
        "at_x_share": float(rng.uniform(-1, 1)),
        "at_y_share": float(rng.uniform(-1, 1)),
    }


def _tag(truth: Truth, size: float, details: Details) -> Truth:
    x, y = truth.watch.tag
    angle = details["heading_rad"]
    return with_watch(truth, tag=(x + size * float(np.cos(angle)), y + size * float(np.sin(angle))))


def _signed(rng: np.random.Generator, truth: Truth) -> Details:
    return {"sign": float(rng.choice([-1.0, 1.0]))}


def _seam(truth: Truth, size: float, details: Details) -> Truth:
    angle, turn = details["heading_rad"], details["turn_rad_per_m"] * size
    return with_watch(
        truth,
        seam=Patch(details["x_m"], details["y_m"], details["radius_m"]),
        seam_shift=(size * float(np.cos(angle)), size * float(np.sin(angle)), turn),
    )


def _seam_draw(rng: np.random.Generator, truth: Truth) -> Details:
    patch = _patch_draw(rng, truth) | {"radius_m": float(rng.uniform(0.2, 0.34))}
    turn = float(rng.choice([-1.0, 1.0])) * float(rng.uniform(0.3, 2.0))
    return heading(rng, truth) | patch | {"turn_rad_per_m": turn}


def _pull(truth: Truth, size: float, details: Details) -> Truth:
    at = (2.0 * float(np.cos(details["heading_rad"])), 2.0 * float(np.sin(details["heading_rad"])))
    return with_place(truth, tether=size * total_mass(truth.body) * 9.81, tether_at=at)


def _gusts(truth: Truth, size: float, details: Details) -> Truth:
    force = size * total_mass(truth.body) * 9.81
    return with_place(truth, fan=force, fan_heading=details["heading_rad"], fan_period=details["period_s"])


def _gusts_draw(rng: np.random.Generator, truth: Truth) -> Details:
    return heading(rng, truth) | {"period_s": float(rng.uniform(5.0, 11.0))}


def _crosstalk(truth: Truth, size: float, details: Details) -> Truth:
    return with_drive(truth, crosstalk=size)


DUTY = ("duty",)

LAWS = (
    Law("wheel_eccentricity", "off_centre_hub", "offset_share_of_radius", 0.001, 0.12, _off_centre, _phases),
    Law("wheel_eccentricity", "oval_tyre", "radius_change_share", 0.001, 0.12, _oval, _phases),
    Law("caster_drag", "seized_ball", "friction_coefficient", 0.04, 1.0,
        lambda t, size, d: with_body(t, caster_grip=size), modes=DUTY, caster="ball"),
    Law("caster_drag", "hair_in_caster", "friction_coefficient", 0.04, 1.0, _hair, modes=DUTY,
        caster="swivel"),
    Law("tyre_scrub", "wide_tyres", "width_share_of_axle", 0.03, 0.6,
        lambda t, size, d: with_body(t, tyre_width=size * t.body.axle), modes=DUTY),
    Law("lateral_slip", "creeping_tyres", "stiffness_in_loads_per_rad", 8.0, 0.5,
        lambda t, size, d: with_body(t, cornering=size), caster="ball",
        kinds=("duckiebot", "kobuki", "cart")),
    Law("payload_offset", "side_load", "mass_share", 0.05, 1.5, _side_load, _load_draw, DUTY),
    Law("payload_offset", "tail_load", "mass_share", 0.05, 1.5, _tail_load, _load_draw, DUTY),
    Law("floor_tilt", "slope", "slope_rad", 0.004, 0.16,
        lambda t, size, d: with_place(t, tilt=(size, d["heading_rad"])), heading, DUTY),
    Law("carpet_nap", "leaning_pile_drag", "drag_share_of_weight", 0.005, 0.25,
        lambda t, size, d: with_place(t, nap_drag=size, nap_heading=d["heading_rad"]), heading, DUTY),
    Law("carpet_nap", "pile_carries", "carried_m_per_m", 0.003, 0.15,
        lambda t, size, d: with_place(t, nap_carry=size, nap_heading=d["heading_rad"]), heading),
    Law("rough_floor_patch", "gravel_or_rug", "rolling_coefficient", 0.01, 0.5, _rough, _patch_draw,
        DUTY, "rough"),
    Law("low_friction_patch", "wet_or_oily", "friction_coefficient", 0.4, 0.01, _slippery, _patch_draw,
        touched="slippery", kinds=("duckiebot", "kobuki", "cart")),
    Law("external_push", "shove", "peak_share_of_weight", 0.1, 4.0, _push, _push_draw, touched="push"),
    Law("sensor_offset", "tag_off_centre", "offset_m", 0.002, 0.12, _tag, heading),
    Law("sensor_yaw", "tag_turned", "yaw_rad", 0.005, 0.35,
        lambda t, size, d: with_watch(t, tag_yaw=t.watch.tag_yaw + d["sign"] * size), _signed),
    Law("clock_drift", "nominal_frame_rate", "rate_error", 0.0005, 0.06,
        lambda t, size, d: with_watch(t, clock=d["sign"] * size), _signed),
    Law("observation_delay", "camera_pipeline", "delay_s", 0.02, 0.6,
        lambda t, size, d: with_watch(t, delay=size), encoders=True),
    Law("observation_delay", "tracker_filter", "time_constant_s", 0.02, 0.6,
        lambda t, size, d: with_watch(t, smoothing=size), encoders=True),
    Law("misplaced_marker", "camera_seam", "shift_m", 0.003, 0.15, _seam, _seam_draw, touched="seam"),
)  # fmt: skip

OUTSIDE = (
    Law("outside", "cable", "pull_share_of_weight_at_1_m", 0.005, 0.3, _pull, heading, DUTY),
    Law("outside", "fan_gusts", "peak_share_of_weight", 0.01, 0.4, _gusts, _gusts_draw, DUTY),
    Law("outside", "shared_ground_wire", "wire_share_of_motor_resistance", 0.05, 3.0, _crosstalk, modes=DUTY),
)
