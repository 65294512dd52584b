"""Everything the per-step laws need, as two numpy records (numba reads them without conversion).

Units are SI; rates and torques are at the wheel (behind the gear); pairs are [left, right].
A zero (or the default below) switches a law off.
"""

from __future__ import annotations

import numpy as np

MAX_CASTERS = 5
MAX_WINDOWS = 6

PAR = np.dtype(
    [
        # body and step
        ("dt", "f8"),
        ("mass", "f8"),
        ("axle", "f8"),
        ("radius", "f8", 2),
        ("sink", "f8"),
        ("normal_k", "f8", 2),
        ("inertia_stick", "f8", 2),
        ("rotor_inertia", "f8", 2),
        # motors: stall torque N m and free rate rad/s at full supply
        ("stall", "f8", 2),
        ("free", "f8", 2),
        ("viscous", "f8", 2),
        ("dry", "f8", 2),
        ("rolling", "f8"),
        # speed controller
        ("rate_control", "f8"),
        ("rate_max", "f8"),
        ("kp", "f8"),
        ("ki", "f8"),
        ("kff", "f8"),
        ("control_steps", "i8"),
        ("counts", "f8"),
        # command chain
        ("dead", "f8", 2),
        ("dead_subtract", "f8"),
        ("limit", "f8"),
        ("limit_soft", "f8"),
        ("curve_power", "f8"),
        ("curve_bridge", "f8"),
        ("reverse", "f8", 2),
        ("reverse_brush", "f8", 2),
        ("lag", "f8", 2),
        ("slew", "f8", 2),
        ("couple", "f8"),
        ("fault_side", "i8"),
        ("fault_loss", "f8"),
        ("fault_chop", "f8"),
        ("fault_from", "f8", MAX_WINDOWS),
        ("fault_to", "f8", MAX_WINDOWS),
        # supply and heat
        ("battery_r", "f8"),
        ("battery_fall", "f8"),
        ("battery_pol", "f8"),
        ("battery_tau", "f8"),
        ("heat", "f8"),
        ("heat_tau", "f8"),
        ("magnet", "f8"),
        ("magnet_tau", "f8"),
        ("grease", "f8"),
        ("grease_tau", "f8"),
        # gear friction and play
        ("static_extra", "f8"),
        ("static_rate", "f8"),
        ("mesh", "f8"),
        ("play_on", "f8"),
        ("play", "f8", 2),
        ("play_k", "f8"),
        ("play_c", "f8"),
        ("encoder_at_wheel", "f8"),
        # wheels and tyres
        ("off_centre", "f8", 2),
        ("off_phase", "f8", 2),
        ("oval", "f8", 2),
        ("scrub_width", "f8"),
        ("scrub_grip", "f8"),
        ("scrub_viscous", "f8"),
        ("grip", "f8"),
        ("grip_side", "f8"),
        ("zone", "f8"),
        ("creep", "f8"),
        # floor
        ("tilt_x", "f8"),
        ("tilt_y", "f8"),
        ("dish", "f8"),
        ("dish_x", "f8"),
        ("dish_y", "f8"),
        ("nap_pull", "f8"),
        ("nap_drag", "f8"),
        ("nap_carry", "f8"),
        ("nap_angle", "f8"),
        ("rough", "f8"),
        ("rough_viscous", "f8"),
        ("rough_x", "f8"),
        ("rough_y", "f8"),
        ("rough_r", "f8"),
        ("slick", "f8"),
        ("slick_film", "f8"),
        ("slick_x", "f8"),
        ("slick_y", "f8"),
        ("slick_r", "f8"),
        # moments
        ("push", "f8"),
        ("push_from", "f8"),
        ("push_time", "f8"),
        ("push_angle", "f8"),
        ("push_arm", "f8"),
        ("push_flat", "f8"),
        # casters (ball load points for the rough patch)
        ("casters", "i8"),
        ("caster_x", "f8", MAX_CASTERS),
        ("caster_y", "f8", MAX_CASTERS),
        ("caster_load", "f8"),
        ("caster_stick", "f8"),
        ("caster_stick_period", "f8"),
        ("caster_stick_share", "f8"),
        # outside the labels
        ("tether_k", "f8"),
        ("tether_x", "f8"),
        ("tether_y", "f8"),
        ("tether_l", "f8"),
        ("wind", "f8"),
        ("wind_x", "f8"),
        ("wind_y", "f8"),
        ("wind_angle", "f8"),
        ("wind_width", "f8"),
        ("compass", "f8"),
        ("compass_angle", "f8"),
        ("trailer", "f8"),
        ("trailer_l", "f8"),
        ("hitch", "f8"),
        ("slosh", "f8"),
        ("slosh_rate", "f8"),
        ("slosh_damp", "f8"),
    ]
)

STATE = np.dtype(
    [
        ("step", "i8"),
        ("filtered", "f8", 2),
        ("integral", "f8", 2),
        ("count", "f8", 2),
        ("duty", "f8", 2),
        ("motor_torque", "f8", 2),
        ("current", "f8"),
        ("polarised", "f8"),
        ("warm", "f8", 2),
        ("rotor", "f8", 2),
        ("rotor_rate", "f8", 2),
        ("rolled", "f8"),
        ("drift_x", "f8"),
        ("drift_y", "f8"),
        ("trailer_angle", "f8"),
        ("slosh_x", "f8"),
        ("slosh_y", "f8"),
        ("slosh_vx", "f8"),
        ("slosh_vy", "f8"),
        ("active", "f8"),
        # what the engine's contacts take over in this step
        ("disc_radius", "f8", 2),
        ("disc_grip", "f8", 2),
        ("disc_zone", "f8", 2),
        ("gravity_x", "f8"),
        ("gravity_y", "f8"),
    ]
)


def blank() -> np.ndarray:
    """A parameter record (shape (1,)) with every law switched off."""
    p = np.zeros(1, PAR)
    p["limit"] = 1.0
    p["curve_power"] = 1.0
    p["reverse"] = 1.0
    p["reverse_brush"] = 1.0
    p["slew"] = 1e9
    p["control_steps"] = 4
    p["counts"] = 1000.0
    p["battery_tau"] = 10.0
    p["heat_tau"] = 30.0
    p["magnet_tau"] = 30.0
    p["grip_side"] = 1.0
    p["grease_tau"] = 20.0
    p["static_rate"] = 1.0
    p["fault_from"] = 1e9
    p["fault_to"] = 1e9
    p["push_from"] = 1e9
    p["push_time"] = 1.0
    p["trailer_l"] = 0.3
    p["caster_stick_period"] = 0.3
    p["slosh_rate"] = 8.0
    p["wind_width"] = 0.5
    return p
