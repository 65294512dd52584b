"""Six kinds of robots, their small unlabelled departures, their cameras and data sheets."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from benchmarks.ode_robots.engine import GRAVITY
from benchmarks.ode_robots.plant import Control, Foot, Pair, Plant, Robot
from benchmarks.robot_sets.driving import Sensing

Rng = np.random.Generator
NUISANCES = ("mass_behind", "rolling", "caster", "asymmetry", "tag")


@dataclass(frozen=True)
class Kind:
    """Ranges of a kind of robot, in SI units; feet: what its third points may be."""

    mass: Pair
    radius: Pair
    axle: Pair
    full: Pair
    area: Pair
    feet: tuple[str, ...]


KINDS = {
    "thimble": Kind((0.7, 1.0), (0.020, 0.024), (0.08, 0.10), (0.20, 0.32), (0.6, 0.9), ("skid",)),
    "desk": Kind((1.0, 1.7), (0.030, 0.036), (0.10, 0.14), (0.30, 0.50), (0.7, 1.1), ("skid", "ball")),
    "sweeper": Kind((2.4, 3.8), (0.034, 0.040), (0.22, 0.26), (0.25, 0.40), (0.8, 1.3), ("skid", "fork")),
    "courier": Kind(
        (4.5, 8.0), (0.048, 0.065), (0.26, 0.33), (0.45, 0.80), (1.1, 1.7), ("skid", "fork", "ball")
    ),
    "shelf": Kind((9.0, 16.0), (0.070, 0.085), (0.32, 0.42), (0.50, 0.90), (1.3, 1.9), ("skid", "fork")),
    "cart": Kind((18.0, 30.0), (0.085, 0.110), (0.40, 0.50), (0.55, 1.00), (1.4, 2.0), ("skid", "fork")),
}


def draw_robot(rng: Rng, needs: frozenset[str], faint: bool) -> Robot:
    """Return a robot; needs: `duty` or `speed`, `ahead` (a firm stand for loads); faint: smaller departures."""
    name = str(rng.choice(sorted(KINDS)))
    kind = KINDS[name]
    small = 0.5 if faint else 1.0
    spread = float(rng.uniform(0.0, 1.0))

    def of(pair: Pair) -> float:
        at = min(max(spread + rng.normal(0.0, 0.12), 0.0), 1.0)
        return float(pair[0] + at * (pair[1] - pair[0]))

    mass, radius, axle, full, area = (
        of(p) for p in (kind.mass, kind.radius, kind.axle, kind.full, kind.area)
    )
    plant = _plant(rng, mass, radius, axle, full, _feet(rng, kind, axle, radius, small), small)
    speed = "speed" in needs or ("duty" not in needs and rng.random() < 1.0 / 3.0)
    mean_free = 0.5 * sum(plant.free)
    control = None
    if speed:
        control = Control(
            0.8 * mean_free,
            float(rng.uniform(1.0, 2.5)),
            float(rng.uniform(3.0, 9.0)),
            float(rng.uniform(0.15, 0.4)),
        )
    tick = float(rng.choice([0.02, 0.04, 0.05, 0.1]))
    sensing = _sensing(rng, small)
    rate = control.full if control else mean_free * (1.0 - _loss(plant))
    sheet = {
        "wheel_radius": radius * _off(rng),
        "axle_length": axle * _off(rng),
        "max_wheel_rate": rate * _off(rng),
        "mass": mass * _off(rng),
    }
    return Robot(name, plant, control, sensing, rate * radius, area, tick, sheet)


def _off(rng: Rng) -> float:
    return float(1.0 + rng.choice([-1.0, 1.0]) * rng.uniform(0.01, 0.04))


def _loss(plant: Plant) -> float:
    """Return the share of full rate that friction takes."""
    return (plant.dry[0] + plant.rolling * 0.45 * plant.mass * GRAVITY * plant.radius[0]) / plant.stall[0]


def _plant(
    rng: Rng, mass: float, radius: float, axle: float, full: float, feet: tuple[Foot, ...], small: float
) -> Plant:
    free = full / radius
    wheel = float(rng.uniform(0.02, 0.045)) * mass
    half = 0.5 * mass * radius**2
    rotor = float(rng.uniform(0.12, 0.4)) * half
    lag = max(full / float(rng.uniform(1.8, 3.2)), 0.07)
    stall = free * (half + rotor + 0.5 * wheel * radius**2) / lag
    unlike = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.001, 0.008))
    motors = [float(v) for v in rng.uniform(-0.025, 0.025, size=4)]
    dry = stall * float(rng.uniform(0.005, 0.02))
    return Plant(
        mass=mass,
        centre=(
            -small * float(rng.uniform(0.02, 0.06)) * axle,
            small * float(rng.uniform(-0.006, 0.006)) * axle,
            float(rng.uniform(0.05, 0.5)) * radius,
        ),
        gyration=axle * float(rng.uniform(0.42, 0.58)),
        axle=axle,
        radius=(radius * (1.0 + 0.5 * unlike), radius * (1.0 - 0.5 * unlike)),
        wheel_mass=wheel,
        stall=(stall * (1.0 + motors[0]), stall * (1.0 + motors[1])),
        free=(free * (1.0 + motors[2]), free * (1.0 + motors[3])),
        rotor=rotor,
        dry=(dry, dry * float(rng.uniform(0.8, 1.25))),
        rolling=float(rng.uniform(0.004, 0.011)),
        friction=float(rng.uniform(0.75, 1.0)),
        creep=(float(rng.uniform(50.0, 90.0)), float(rng.uniform(35.0, 60.0))),
        backwards=small * float(rng.uniform(0.0, 0.006)),
        feet=feet,
    )


def _feet(rng: Rng, kind: Kind, axle: float, radius: float, small: float) -> tuple[Foot, ...]:
    """Return a foot behind, which the robot leans on, and a skid ahead, just above the floor."""
    rear = -float(rng.uniform(0.5, 0.75)) * axle
    front = float(rng.uniform(0.5, 0.75)) * axle
    form = str(rng.choice(kind.feet))
    slides = small * float(rng.uniform(0.02, 0.06))
    ahead = Foot(front, 0.0, 0.03, gap=0.0003)
    if form == "fork":
        behind = Foot(rear, 0.0, 0.01, kind="fork", trail=0.35 * radius, swivel=0.02)
    elif form == "ball":
        behind = Foot(rear, 0.0, slides, kind="ball")
    else:
        behind = Foot(rear, 0.0, slides)
    return (behind, ahead)


def _sensing(rng: Rng, small: float) -> Sensing:
    angle = float(rng.uniform(-math.pi, math.pi))
    away = small * float(rng.uniform(0.001, 0.002))
    return Sensing(
        rate=float(rng.choice([10.0, 15.0, 20.0, 30.0, 50.0, 60.0])),
        noise_xy=math.exp(float(rng.uniform(math.log(0.0005), math.log(0.003)))),
        noise_theta=math.exp(float(rng.uniform(math.log(0.003), math.log(0.012)))),
        missing=float(rng.uniform(0.0, 0.03)),
        tail=0.03 if rng.random() < 1.0 / 3.0 else 0.0,
        gaps=int(rng.integers(0, 3)),
        tag=(away * math.cos(angle), away * math.sin(angle)),
        tag_yaw=0.0,
        encoder_ticks=int(rng.choice([360, 512, 979, 1440, 2048])) if rng.random() < 0.5 else 0,
    )


def without(robot: Robot, name: str) -> Robot:
    """Return a robot that lacks one of its departures."""
    plant = robot.plant
    if name == "tag":
        return replace(robot, sensing=replace(robot.sensing, tag=(0.0, 0.0)))
    if name == "mass_behind":
        changed = replace(plant, centre=(0.0, 0.0, plant.centre[2]))
    elif name == "rolling":
        changed = replace(plant, rolling=0.0)
    elif name == "caster":
        changed = replace(plant, feet=tuple(replace(f, kind="skid", friction=0.0) for f in plant.feet))
    elif name == "asymmetry":
        changed = replace(plant, backwards=0.0)
    else:
        raise ValueError(name)
    return replace(robot, plant=changed)


def described(robot: Robot) -> dict[str, Any]:
    """Return the numbers of a robot for the key."""
    told = asdict(robot.plant)
    cx, cy, cz = told.pop("centre")
    return {
        "kind": robot.kind,
        **told,
        "centre_x": cx,
        "centre_y": cy,
        "centre_z": cz,
        "full_speed": robot.full,
        "area": robot.area,
        "tick": robot.tick,
    }
