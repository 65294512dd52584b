"""An expert's library for sparse regression: terms of forward, turning and sideways motion, each with its effect's name.

A state is a mapping of arrays of one shape: v [m/s], w [rad/s], x, y [m], theta [rad], t [s], left, right [1], their
rates d_left, d_right [1/s], roll_left, roll_right [rad]. `terms` returns (name of the effect, equation, values), the
base robot's own terms under the name "base"; equation 0: dv/dt, 1: dw/dt, 2: sideways speed.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from peers.data import AXLE

State = Mapping[str, np.ndarray]
PLACES = [(x, y) for x in (-0.3, 0.0, 0.3) for y in (-0.3, 0.0, 0.3)]
PLACE_SIZE = 0.2  # m
MOMENTS = np.arange(7.5, 60.0, 7.5)  # s, middles of the time windows for faults and pushes


def terms(s: State) -> list[tuple[str, int, np.ndarray]]:
    """Evaluate all terms."""
    both, apart = s["left"] + s["right"], s["right"] - s["left"]
    rows: list[tuple[str, int, np.ndarray]] = []

    def add(name: str, forward: np.ndarray | None = None, turn: np.ndarray | None = None) -> None:
        rows.extend((name, k, value) for k, value in enumerate((forward, turn)) if value is not None)

    for wheel in (s["left"], s["right"], s["v"], s["w"]):
        add("base", wheel, wheel)
    add("motor_deadband", *_of_wheels(s, lambda u: np.tanh(u / 0.03)))
    add("motor_gain_curve", *_of_wheels(s, lambda u: u * np.abs(u)))
    add("command_saturation", *_of_wheels(s, lambda u: np.sign(u) * np.maximum(np.abs(u) - 0.33, 0.0)))
    add("motor_reverse_asymmetry", *_of_wheels(s, lambda u: np.minimum(u, 0.0)))
    slowing = np.sign(s["v"]) * np.maximum(np.sign(s["v"]) * (s["v"] - 0.6 * both / 2.0), 0.0)
    add("motor_asymmetric_lag", slowing)
    add("coulomb_friction", np.tanh(s["v"] / 0.02), np.tanh(s["w"] / 0.2))
    add("caster_drag", np.tanh(s["v"] / 0.02) * np.abs(s["w"]), np.tanh(s["v"] / 0.02) * s["w"])
    add("tyre_scrub", None, np.tanh(s["w"] / 0.2) / (1.0 + np.abs(s["v"]) / 0.05))
    add("gear_backlash", *_of_rates(s, lambda rate: np.tanh(rate / 0.5)))
    add("command_delay", *_of_rates(s, lambda rate: rate))
    add("clock_drift", *(s["t"] / 60.0 * rate for rate in _of_rates(s, lambda rate: rate)))
    add("battery_sag", s["t"] / 60.0 * both, s["t"] / 60.0 * apart)
    for side in ("left", "right"):
        warm = (1.0 - np.exp(-s["t"] / 25.0)) * s[side]
        add("motor_warmup", warm, warm)
        for turned in (np.cos(s[f"roll_{side}"]), np.sin(s[f"roll_{side}"])):
            add("wheel_eccentricity", turned * s[side], turned * s[side])
        for moment in MOMENTS:
            lost = (np.abs(s["t"] - moment) < 3.75) * s[side]
            add("motor_fault", lost, lost)
    for moment in MOMENTS:
        near = np.exp(-(((s["t"] - moment) / 2.0) ** 2))
        add("external_push", near, near)
    c, n = np.cos(s["theta"]), np.sin(s["theta"])
    moving = np.tanh(s["v"] / 0.02)
    for direction in (c, n):
        add("floor_tilt", direction)
        add("carpet_nap", moving * moving * direction)
    add("payload_offset", s["w"] ** 2, s["v"] * s["w"])
    for px, py in PLACES:
        near = np.exp(-((s["x"] - px) ** 2 + (s["y"] - py) ** 2) / (2.0 * PLACE_SIZE**2))
        add("rough_floor_patch", near * moving)
        add("low_friction_patch", near * both, near * apart)
        rows.append(("misplaced_marker", 2, near * s["v"]))
    rows += [("sensor_yaw", 2, s["v"]), ("sensor_offset", 2, s["w"]), ("lateral_slip", 2, s["v"] * s["w"])]
    return rows


def _of_wheels(s: State, curve) -> tuple[np.ndarray, np.ndarray]:
    left, right = curve(s["left"]), curve(s["right"])
    return left + right, (right - left) / AXLE


def _of_rates(s: State, curve) -> tuple[np.ndarray, np.ndarray]:
    left, right = curve(s["d_left"]), curve(s["d_right"])
    return left + right, (right - left) / AXLE
