"""Seven kinds of robots, drawn with the small departures that every real one has."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.rapier_robots.plant import Caster, Control, Plant, Robot, Sensing

Rng = np.random.Generator
Range = tuple[float, float]


@dataclass(frozen=True)
class Kind:
    """A robot as sold: ranges of mass [kg], wheel radius [m], axle [m], full speed [m/s], mass off the axle [m]."""

    name: str
    mass: Range
    radius: Range
    axle: Range
    speed: Range
    behind: Range
    reach: float
    caster: str
    height: float
    encoder: tuple[int, ...]


KINDS = (
    Kind(
        "desk",
        (0.7, 0.9),
        (0.02, 0.022),
        (0.08, 0.095),
        (0.2, 0.32),
        (0.003, 0.005),
        0.04,
        "ball",
        0.012,
        (360, 900),
    ),
    Kind(
        "school",
        (0.9, 1.2),
        (0.031, 0.034),
        (0.1, 0.115),
        (0.35, 0.5),
        (0.003, 0.006),
        0.06,
        "ball",
        0.02,
        (135, 270),
    ),
    Kind(
        "kit",
        (1.2, 1.8),
        (0.034, 0.036),
        (0.135, 0.145),
        (0.4, 0.6),
        (0.003, 0.009),
        0.07,
        "ball",
        0.018,
        (1440,),
    ),
    Kind(
        "disc",
        (2.8, 4.2),
        (0.035, 0.037),
        (0.225, 0.24),
        (0.35, 0.5),
        (0.006, 0.02),
        0.125,
        "ball",
        0.02,
        (509, 2578),
    ),
    Kind(
        "shelf",
        (6.0, 12.0),
        (0.06, 0.075),
        (0.32, 0.4),
        (0.5, 0.7),
        (0.01, 0.025),
        0.16,
        "ball",
        0.06,
        (1024, 2000),
    ),
    Kind(
        "lab",
        (9.0, 13.0),
        (0.09, 0.1),
        (0.31, 0.35),
        (0.5, 0.8),
        (0.012, 0.025),
        0.2,
        "fork",
        0.06,
        (500, 2000),
    ),
    Kind(
        "cart",
        (16.0, 30.0),
        (0.08, 0.11),
        (0.42, 0.5),
        (0.6, 0.9),
        (0.012, 0.025),
        0.28,
        "fork",
        0.09,
        (1024, 4096),
    ),
)
CHANCES = (0.14, 0.18, 0.16, 0.18, 0.16, 0.1, 0.08)


def between(rng: Rng, limits: Range) -> float:
    """Return a number drawn evenly from a range."""
    return float(rng.uniform(*limits))


def about(rng: Rng, low: float, high: float) -> float:
    """Return a factor that is off one by `low` to `high` either way."""
    return 1.0 + float(rng.choice((-1.0, 1.0))) * between(rng, (low, high))


def _casters(rng: Rng, kind: Kind, mass: float, faint: bool) -> tuple[Caster, ...]:
    reach = kind.reach * about(rng, 0.0, 0.1)
    front = Caster(reach, radius=0.2 * kind.radius[0], friction=0.03, lift=0.0006)
    if kind.caster == "fork" and not faint:
        radius, trail = 0.4 * kind.radius[0], 0.12 * reach
        load = 0.15 * mass * 9.81
        pivot, roll = 0.01 * load * trail * between(rng, (0.5, 1.5)), 0.006 * load * radius
        return (Caster(-reach, kind="fork", radius=radius, trail=trail, pivot=pivot, roll=roll), front)
    slide = between(rng, (0.008, 0.025) if faint else (0.01, 0.05))
    return (Caster(-reach, radius=0.25 * kind.radius[0], friction=slide), front)


def draw_plant(rng: Rng, kind: Kind, faint: bool) -> Plant:
    """Return the robot as built: nothing on it is quite as meant."""
    mass, radius, axle = between(rng, kind.mass), between(rng, kind.radius), between(rng, kind.axle)
    radii = 1.0 + float(rng.choice((-1.0, 1.0))) * between(rng, (0.0005, 0.004))
    free = between(rng, kind.speed) / radius
    lag = between(rng, (0.045, 0.1))  # s: time constant of the free robot with its motors
    wheel_mass = 0.03 * mass
    armature = 0.25 * mass * radius**2 * between(rng, (0.3, 1.0))
    stall = (0.5 * mass * radius**2 + armature) * free / lag
    strong, fast = about(rng, 0.005, 0.03), about(rng, 0.002, 0.015)
    dry = stall * between(rng, (0.002, 0.004) if faint else (0.002, 0.008))
    uneven = about(rng, 0.0, 0.15)
    roll = between(rng, (0.002, 0.004) if faint else (0.002, 0.007))
    body = 0.9 * kind.reach + 0.3 * axle
    side = float(rng.normal(0.0, 0.0008))
    com = (-between(rng, kind.behind) * (0.7 if faint else 1.0), side, kind.height)
    inertia = mass * np.array([axle**2 / 9, body**2 / 5, (axle**2 / 9 + body**2 / 5)]) * about(rng, 0.0, 0.2)
    return Plant(
        mass=mass - 2 * wheel_mass,
        com=com,
        inertia=(float(inertia[0]), float(inertia[1]), float(inertia[2])),
        radius=(radius * radii, radius / radii),
        axle=axle,
        grip=(between(rng, (0.7, 1.0)),) * 2,
        wheel_mass=wheel_mass,
        armature=(armature, armature),
        dry=(dry * uneven, dry / uneven),
        rolling=(roll, roll),
        viscous=(0.0, 0.0),
        stall=(stall * strong, stall / strong),
        free=(free * fast, free / fast),
        casters=_casters(rng, kind, mass, faint),
    )


def draw_control(rng: Rng, kind: Kind, plant: Plant) -> Control:
    """Return a speed controller of good or middling quality."""
    ahead = float(rng.choice((0.0, 0.9, 1.0), p=(0.35, 0.3, 0.35)))
    return Control(
        period=float(rng.choice((0.01, 0.02, 0.03, 0.05))),
        kp=between(rng, (0.4, 1.2)) if ahead else between(rng, (0.8, 2.0)),
        ki=between(rng, (1.5, 5.0)) if ahead else between(rng, (5.0, 11.0)),
        ahead=ahead,
        windup=between(rng, (0.4, 0.8)) if ahead else 1.0,
        smooth=float(rng.choice((0.0, 0.02, 0.04))),
        ticks=int(4 * rng.choice(kind.encoder)),
        full=0.82 * min(plant.free),
    )


def draw_sensing(rng: Rng, kind: Kind) -> Sensing:
    """Return how the robot is watched."""
    noise = between(rng, (0.0005, 0.002) if kind.mass[0] < 2 else (0.0008, 0.003))
    return Sensing(
        rate=float(rng.choice((10.0, 15.0, 20.0, 25.0, 30.0, 50.0, 60.0))),
        noise_xy=noise,
        noise_theta=between(rng, (0.003, 0.012)),
        tail=float(rng.choice((0.0, 0.0, 0.03))),
        missing=float(rng.choice((0.0, 0.01, 0.03))),
        gaps=int(rng.choice((0, 0, 0, 1, 2))),
        encoder_ticks=int(rng.choice(kind.encoder)) if rng.random() < 0.5 else 0,
        tag=(between(rng, (-0.002, 0.002)), between(rng, (-0.0015, 0.0015))),
        tag_yaw=between(rng, (-0.005, 0.005)),
    )


def draw_robot(rng: Rng, needs: frozenset[str], faint: bool) -> Robot:
    """Return a robot that has what an effect needs: "duty", "speed", "fork", "ball"."""
    chances = np.array(CHANCES)
    for n, kind in enumerate(KINDS):
        if ("fork" in needs and kind.caster != "fork") or ("ball" in needs and kind.caster == "fork"):
            chances[n] = 0.0
        if "fork" not in needs and faint and kind.caster == "fork":
            chances[n] *= 0.3
    kind = KINDS[int(rng.choice(len(KINDS), p=chances / chances.sum()))]
    plant = draw_plant(rng, kind, faint and "fork" not in needs)
    steered = rng.random() < 0.65
    control = (
        draw_control(rng, kind, plant) if "speed" in needs or (steered and "duty" not in needs) else None
    )
    sensing = draw_sensing(rng, kind)
    full = control.full if control else sum(plant.free) / 2.0
    sheet = {
        "wheel_radius": round(sum(plant.radius) / 2.0 * about(rng, 0.01, 0.03), 5),
        "axle_length": round(plant.axle * about(rng, 0.01, 0.03), 4),
        "max_wheel_rate": round(full * about(rng, 0.01, 0.04), 3),
    }
    if rng.random() < 0.7:
        sheet["mass"] = round(plant.total * about(rng, 0.005, 0.03), 3)
    top = full * sum(plant.radius) / 2.0
    area = float(np.clip(between(rng, (1.4, 2.6)) * top, 0.6, 2.0))
    return Robot(kind.name, plant, control, sensing, sheet, full, area, float(rng.choice((0.02, 0.04, 0.05))))


def without(robot: Robot, nuisance: str) -> Robot:
    """Return the robot without one of its departures."""
    p = robot.plant
    if nuisance == "mass_behind":
        keep = 0.1 if p.casters[0].kind == "fork" else 0.15  # the caster stays on the floor
        return replace(robot, plant=replace(p, com=(keep * p.com[0], 0.0, p.com[2])))
    if nuisance == "rolling":
        return replace(robot, plant=replace(p, dry=(0.0, 0.0), rolling=(0.0, 0.0)))
    if nuisance == "caster":
        smooth = tuple(
            replace(c, kind="ball", friction=0.0, trail=0.0, pivot=0.0, roll=0.0) for c in p.casters
        )
        return replace(robot, plant=replace(p, casters=smooth))
    if nuisance == "tag":
        return replace(robot, sensing=replace(robot.sensing, tag=(0.0, 0.0), tag_yaw=0.0))
    raise KeyError(nuisance)


NUISANCES = ("mass_behind", "rolling", "caster", "tag")


def described(robot: Robot) -> dict[str, Any]:
    """Return the robot's numbers for the key."""
    p = robot.plant
    return {
        "kind": robot.kind,
        "control": "speed" if robot.control else "duty",
        "mass": p.total,
        "centre_x": p.com[0] * p.mass / p.total,
        "centre_y": p.com[1] * p.mass / p.total,
        "radius": list(p.radius),
        "axle": p.axle,
        "stall": list(p.stall),
        "free": list(p.free),
        "dry": list(p.dry),
        "rolling": list(p.rolling),
        "grip": p.grip[0],
        "caster": p.casters[0].kind,
        "caster_friction": p.casters[0].friction,
        "full_rate": robot.full_rate,
        "time_constant": _lag(p),
    }


def _lag(p: Plant) -> float:
    inertia = 0.5 * p.total * p.radius[0] ** 2 + p.armature[0]
    return inertia * p.free[0] / p.stall[0] if p.stall[0] else math.inf
