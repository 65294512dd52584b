"""Robots as shops sell them: 0.5 to 25 kg, a data sheet that is nearly right, two to four small departures.

Sizes scale with the cube root of mass; torque is chosen for a mechanical time constant of 60 to 200 ms.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from foreign.laws_command import shape
from foreign.planar import FX, FY
from foreign.setup import Array, Place, Setup, Track, add_mass


@dataclass(frozen=True)
class Robot:
    """What a robot is before any effect; `sheet` is what its data sheet says."""

    name: str
    engine: str
    parts: dict[str, Any]  # arguments of Setup: left, right, supply, body, size, speed, reach
    sheet: dict[str, float]
    departures: tuple[tuple[str, float], ...]  # name and size (share of its largest)
    sensing: dict[str, float]  # rate [Hz], noise [m], turn_noise [rad], tails, dropped, ticks (0 = none)
    command: str  # normalized or twist
    seed: int = 0
    pieces: dict[str, float] = field(default_factory=dict)  # that it has from the start, in Drake


def draw_robot(
    rng: np.random.Generator, name: str, engine: str, label_names: tuple[str, ...], mass: float = 0.0
) -> Robot:
    """Draw a robot whose departures are none of the labelled effects; of a mass [kg], 0: drawn as well."""
    drawn = float(np.exp(rng.uniform(np.log(0.5), np.log(25.0))))
    mass = mass or drawn
    scale = mass ** (1 / 3)
    radius = 0.032 * scale * float(rng.uniform(0.8, 1.25))
    axle = max(0.12 * scale * float(rng.uniform(0.85, 1.25)), 2.2 * radius)
    speed = float(rng.uniform(0.35, 0.6)) * scale**0.4
    no_load = speed / radius
    tau = float(rng.uniform(0.06, 0.2))
    rotor = float(rng.uniform(0.15, 0.5)) * mass * radius**2 / 2
    stall = (mass * radius**2 / 2 + rotor) * no_load / tau
    side = float(rng.uniform(-0.05, 0.05))
    motor = {
        "stall": stall,
        "no_load": no_load,
        "rotor": rotor,
        "viscous": 0.01 * stall / no_load,
        "coulomb": 0.006 * stall,
    }
    body = {
        "mass": mass,
        "inertia": mass * (axle * float(rng.uniform(0.36, 0.5))) ** 2,
        "com_x": -float(rng.uniform(0.02, 0.06)) * axle,
        "com_y": 0.0,
        "axle": axle,
        "radius_left": radius,
        "radius_right": radius,
        "caster_x": -0.7 * axle,
        "friction": float(rng.uniform(0.6, 0.95)),
        "stiffness": float(rng.uniform(4.0, 9.0)),
        "tyre": int(rng.integers(3)),
        "caster_trail": 0.22 * 0.7 * axle,
        "rolling": 0.008,
        "caster_rolling": 0.01,
        "caster_swivel": 0.0,
    }
    parts = {
        "left": {**motor, "gain": 1.0 + side},
        "right": {**motor, "gain": 1.0 - side},
        "supply": {"series": 0.01},
        "body": body,
        "size": axle,
        "speed": speed,
        "reach": 9.0 * axle,
    }
    sheet = {
        "wheel_radius": round(radius * float(rng.uniform(0.975, 1.025)), 4),
        "axle_length": round(axle * float(rng.uniform(0.975, 1.025)), 3),
        "max_wheel_rate": round(no_load * float(rng.uniform(0.93, 1.07)), 1),
    }
    sensing = {
        "rate": float(rng.choice([10.0, 15.0, 20.0, 30.0, 50.0])),
        "noise": float(rng.uniform(0.001, 0.003)),
        "turn_noise": float(np.deg2rad(rng.uniform(0.3, 1.0))),
        "tails": float(rng.choice([4.0, 6.0, 30.0])),
        "outliers": float(rng.uniform(0.0, 0.006)),
        "dropped": float(rng.uniform(0.0, 0.05)),
        "ticks": float(rng.choice([90, 135, 270, 540, 1024, 2048])) if rng.random() < 0.5 else 0.0,
    }
    return Robot(
        name, engine, parts, sheet, draw_departures(rng, label_names, engine), sensing,
        "twist" if rng.random() < 0.2 else "normalized", int(rng.integers(2**31)),
    )  # fmt: skip


def _mass_behind(setup: Setup, k: float, small: float) -> None:
    setup.body["com_x"] -= small * (0.005 + 0.015 * k) * (setup.size / 0.12) ** 0.5
    setup.pieces["com_behind"] = setup.body["com_x"]


def _rolling(setup: Setup, k: float, small: float) -> None:
    setup.body["rolling"] += 0.015 * k * small


def _curve(setup: Setup, k: float, small: float) -> None:
    shape(setup, "left" if int(97 * k) % 2 else "right", lambda a, _: a + 0.12 * small * k * a * (1 - a))


def _asymmetry(setup: Setup, k: float, small: float) -> None:
    shape(
        setup,
        "right" if k < 0.5 else "left",
        lambda a, sign: np.where(sign < 0, a * (1 - 0.03 * small * (0.3 + 0.7 * k)), a),
    )


def _caster(setup: Setup, k: float, small: float) -> None:
    setup.body["caster_rolling"] += 0.03 * k * small
    setup.body["caster_swivel"] += 0.01 * k * small * abs(setup.body["caster_x"])


def _tag(setup: Setup, k: float, small: float) -> None:
    a, far = 40.0 * k, small * (0.001 + 0.004 * k)

    def act(track: Track) -> None:
        track.mount = track.mount + np.array(
            [far * np.cos(a), far * np.sin(a), 0.003 * small * np.sin(2 * a)]
        )

    setup.sensing.append(act)


def _more_mass(setup: Setup, k: float, small: float) -> None:
    add_mass(setup, 0.10 * small * (k + 0.3) * setup.body["mass"], 0.0, 0.0)


def _rotor(setup: Setup, k: float, small: float) -> None:
    for wheel in setup.wheels("both"):
        wheel["rotor"] *= 1.0 + 0.5 * small * (k - 0.4)


def _viscous(setup: Setup, k: float, small: float) -> None:
    for wheel in setup.wheels("both"):
        wheel["viscous"] += 0.02 * k * small * setup.stall / wheel["no_load"]


def _uneven_floor(setup: Setup, k: float, small: float) -> None:
    pull, way = 0.003 * k * small * setup.weight, 50.0 * k

    def act(_: float, state: Array, hook: Array) -> None:
        swell = np.sin(3.0 * state[0] / setup.reach + way) * pull
        hook[FX] += swell * np.cos(way)
        hook[FY] += swell * np.sin(way)

    setup.hooks.append(act)


DEPARTURES: dict[str, tuple[Callable[[Setup, float, float], None], frozenset[str]]] = {
    "mass_behind": (_mass_behind, frozenset({"payload_offset"})),
    "rolling": (_rolling, frozenset({"coulomb_friction", "caster_drag"})),
    "curve": (_curve, frozenset({"motor_gain_curve"})),
    "asymmetry": (_asymmetry, frozenset({"motor_reverse_asymmetry"})),
    "caster": (_caster, frozenset({"caster_drag"})),
    "tag": (_tag, frozenset({"sensor_offset", "sensor_yaw"})),
    "more_mass": (_more_mass, frozenset({"payload_offset"})),
    "rotor": (_rotor, frozenset()),
    "viscous": (_viscous, frozenset()),
    "uneven_floor": (_uneven_floor, frozenset({"floor_tilt"})),
}


def draw_departures(
    rng: np.random.Generator, labels: tuple[str, ...], engine: str
) -> tuple[tuple[str, float], ...]:
    """Draw two to four small departures, none of them a labelled effect; mass behind the axle is nearly always one."""
    names = [n for n, (_, same) in DEPARTURES.items() if not same & set(labels) and n != "mass_behind"]
    if engine != "planar":
        fixed = {"caster"} if engine == "drake" else {"rolling", "caster"}
        names = [n for n in names if n not in fixed]
    picked = [str(n) for n in rng.choice(names, int(rng.integers(1, 4)), replace=False)]
    if "payload_offset" not in labels:
        picked = ["mass_behind", *picked]
    return tuple((n, float(rng.uniform(0, 1))) for n in picked)


def build(
    robot: Robot,
    place: Place | None,
    window: tuple[float, float] | None,
    salt: int,
    small: float,
    engine: str,
) -> Setup:
    """Return a fresh setup of a robot with its departures, each `small` times its drawn size, and no labelled effect."""
    p = robot.parts
    setup = Setup(
        dict(p["left"]), dict(p["right"]), dict(p["supply"]), dict(p["body"]), p["size"], p["speed"], place, window,
        p["reach"], engine, salt,
    )  # fmt: skip
    if robot.seed % 2:
        setup.pieces["swivel_caster"] = 1.0  # in MuJoCo
    setup.pieces.update(robot.pieces)
    if small > 0:
        for name, size in robot.departures:
            DEPARTURES[name][0](setup, size, small)
    return setup
