"""Six kinds of robots with the proportions of real ones, drawn with small imperfections that carry no
label.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from benchmarks.box2d_robots.parts import Control, Pair, Plant, Robot, Third
from benchmarks.robot_sets.driving import Sensing

Rng = np.random.Generator
Range = tuple[float, float]


@dataclass(frozen=True)
class Kind:
    """Ranges of a kind: mass [kg], radius, axle [m], full speed [m/s], area [m], volts, third points; stall
    force over weight.
    """

    mass: Range
    radius: Range
    axle: Range
    speed: Range
    area: Range
    volts: float
    thirds: tuple[str, ...]
    pull: Range


KINDS = {
    "kit": Kind(
        (0.5, 0.8), (0.031, 0.034), (0.12, 0.15), (0.35, 0.6), (0.7, 1.1), 6.0, ("ball", "skid"), (0.35, 0.5)
    ),
    "duckie": Kind(
        (1.0, 1.4), (0.031, 0.034), (0.095, 0.11), (0.3, 0.5), (0.7, 1.1), 7.4, ("ball",), (0.35, 0.55)
    ),
    "burger": Kind(
        (0.9, 1.3),
        (0.032, 0.034),
        (0.155, 0.165),
        (0.2, 0.26),
        (0.6, 0.9),
        11.1,
        ("ball", "glides"),
        (0.4, 0.6),
    ),
    "vacuum": Kind(
        (2.8, 4.0),
        (0.034, 0.038),
        (0.23, 0.26),
        (0.3, 0.5),
        (0.8, 1.3),
        14.4,
        ("fork", "skid", "glides"),
        (0.35, 0.5),
    ),
    "pioneer": Kind(
        (9.0, 14.0), (0.085, 0.1), (0.32, 0.38), (0.55, 0.9), (1.3, 1.9), 12.0, ("fork", "skid"), (0.3, 0.45)
    ),
    "tug": Kind(
        (20.0, 30.0),
        (0.08, 0.11),
        (0.42, 0.52),
        (0.55, 0.95),
        (1.4, 2.0),
        24.0,
        ("fork", "glides", "skid"),
        (0.3, 0.45),
    ),
}
# like a maker's kit with yellow gear motors, Duckiebot DB21, TurtleBot3 Burger, Create 2, Pioneer 3-DX,
# a warehouse tug
SLIDERS = ("ball", "skid", "glides")
TICKS = (0.02, 0.03, 0.04, 0.05, 0.06, 0.08, 0.1)  # s


def _third(rng: Rng, kind: str, radius: float, axle: float, calm: float) -> Third:
    slide = {
        "ball": rng.uniform(0.04, 0.12),
        "skid": rng.uniform(0.1, 0.2),
        "glides": rng.uniform(0.1, 0.2),
    }
    return Third(
        kind,
        x=-float(rng.uniform(0.42, 0.6)) * axle,
        half_y=float(rng.uniform(0.15, 0.3)) * axle if kind == "glides" else 0.0,
        ahead=float(rng.uniform(0.4, 0.55)) * axle,
        slide=float(slide[kind]) * calm if kind in slide else 0.15 * calm,
        roll=float(rng.uniform(0.01, 0.025)) * calm,
        trail=float(rng.uniform(0.25, 0.4)) * radius,
        swivel=float(rng.uniform(0.01, 0.03)) * radius * calm,
    )


def _unlike(rng: Rng, mean: float, spread: float) -> Pair:
    off = float(rng.uniform(-spread, spread))
    return mean * (1.0 + off), mean * (1.0 - off)


def _plant(rng: Rng, kind: Kind, third: str, calm: float) -> tuple[Plant, float]:
    """Return a plant and its full speed [m/s]; `calm` scales the departures."""
    u = rng.uniform
    mass, radius, axle, speed = u(*kind.mass), u(*kind.radius), u(*kind.axle), u(*kind.speed)
    efficiency = float(u(0.75, 0.92))
    stall = u(*kind.pull) * mass * 9.81 * radius / 2
    emf = kind.volts / (1.1 * speed / radius)
    winding = efficiency * emf * kind.volts / stall
    behind = u(0.01, 0.03) * axle * calm
    gyration = u(0.42, 0.5) * axle
    centre = (-behind, float(u(-0.006, 0.006)) * axle * calm, float(u(0.7, 1.3)) * radius)
    dry = float(u(0.005, 0.018)) * stall
    share = u(0.1, 0.3) * mass * radius**2 / 2  # of the rotor, seen through the gear
    return Plant(
        mass=float(mass),
        inertia=float(mass * (gyration**2 + behind**2)),
        centre=(float(centre[0]), centre[1], centre[2]),
        axle=float(axle),
        radius=_unlike(rng, float(radius), 0.003 * calm),
        wheel_inertia=float(u(0.02, 0.05) * mass * radius**2),
        rotor_inertia=float(share),
        volts=kind.volts,
        torque_const=_unlike(rng, float(emf), 0.02 * calm),
        emf_const=_unlike(rng, float(emf), 0.012 * calm),
        winding=_unlike(rng, float(winding), 0.02 * calm),
        electric_lag=float(u(0.0002, 0.0012)),
        efficiency=efficiency,
        dry=_unlike(rng, dry, 0.15 * calm),
        viscous=(0.0, 0.0),
        rolling=float(u(0.003, 0.008)) * math.sqrt(calm),
        grip=float(u(0.75, 1.0)),
        stiff=(float(u(25.0, 45.0)), float(u(16.0, 30.0))),
        relax=float(u(0.15, 0.3) * radius),
        third=_third(rng, third, float(radius), float(axle), calm),
    ), float(speed)


def full_rate(plant: Plant) -> float:
    """Return the rate of the wheels at full duty, driving straight [rad/s]."""
    held = sum(plant.dry) / 2 + plant.rolling * plant.mass * 9.81 / 2 * plant.radius[0]
    return plant.free() * (1.0 - held / plant.stall())


def full_speed(plant: Plant, control: Control | None) -> float:
    """Return the speed at full command [m/s]."""
    rate = control.full if control else full_rate(plant)
    return rate * sum(plant.radius) / 2


def _sensing(rng: Rng, calm: float) -> Sensing:
    far, at = rng.uniform(0.001, 0.002) * calm, rng.uniform(-math.pi, math.pi)
    return Sensing(
        rate=float(rng.choice([10.0, 15.0, 20.0, 25.0, 30.0, 50.0, 60.0])),
        noise_xy=float(math.exp(rng.uniform(math.log(0.0005), math.log(0.003)))),
        noise_theta=float(math.exp(rng.uniform(math.log(0.003), math.log(0.012)))),
        tail=0.03 if rng.random() < 0.33 else 0.0,
        missing=float(rng.uniform(0.0, 0.03)),
        gaps=int(rng.integers(0, 3)),
        tag=(float(far * math.cos(at)), float(far * math.sin(at))),
        tag_yaw=0.0,
        encoder_ticks=int(rng.choice([360, 600, 960, 1320, 2048])) if rng.random() < 0.5 else 0,
    )


def _control(rng: Rng, plant: Plant) -> Control:
    full = float(rng.uniform(0.72, 0.88)) * full_rate(plant)
    return Control(
        full=full,
        feed=float(rng.uniform(0.9, 1.0)) * full / plant.free(),
        gain=float(rng.uniform(0.5, 1.4)),
        integral=float(rng.uniform(3.0, 9.0)),
        ramp=float(rng.uniform(4.0, 12.0)),
        period=float(rng.choice([0.01, 0.02])),
    )


def _wanted(rng: Rng, needs: frozenset[str]) -> tuple[str, str]:
    """Return kind and third point; laws may need a fork or something that slides."""
    pairs = [
        (name, third)
        for name, kind in KINDS.items()
        for third in kind.thirds
        if not ("fork" in needs and third != "fork") and not ("slider" in needs and third == "fork")
    ]
    names = sorted({name for name, _ in pairs})
    name = str(rng.choice(names))
    return name, str(rng.choice([third for n, third in pairs if n == name]))


def draw_robot(rng: Rng, needs: frozenset[str], faint: bool) -> Robot:
    """Return a robot; faint and clean ones have departures half as large."""
    calm = 0.5 if faint else 1.0
    name, third = _wanted(rng, needs)
    kind = KINDS[name]
    plant, _ = _plant(rng, kind, third, calm)
    control = _control(rng, plant) if rng.random() < 0.36 and "duty" not in needs else None
    rate = control.full if control else full_rate(plant)

    def about(value: float) -> float:
        return float(value * (1.0 + rng.uniform(0.01, 0.04) * rng.choice([-1.0, 1.0])))

    sheet = {
        "wheel_radius": about(sum(plant.radius) / 2),
        "axle_length": about(plant.axle),
        "max_wheel_rate": about(rate),
        "mass": about(plant.mass),
    }
    return Robot(
        kind=name,
        plant=plant,
        sensing=_sensing(rng, calm),
        control=control,
        area=float(rng.uniform(*kind.area)),
        tick=float(rng.choice(TICKS)),
        sheet=sheet,
        reverse=float(rng.uniform(0.0, 0.006)) * calm,
    )


def _mean(pair: Pair) -> Pair:
    return (sum(pair) / 2,) * 2


def _no_mass_behind(robot: Robot) -> Robot:
    return robot.changed(centre=(0.0, 0.0, robot.plant.centre[2]))


def _no_caster(robot: Robot) -> Robot:
    return robot.changed(third=replace(robot.plant.third, slide=0.0, roll=0.0, swivel=0.0))


def _no_asymmetry(robot: Robot) -> Robot:
    p = robot.plant
    names = ("radius", "torque_const", "emf_const", "winding", "dry")
    return replace(robot.changed(**{n: _mean(getattr(p, n)) for n in names}), reverse=0.0)


def _no_tag(robot: Robot) -> Robot:
    return replace(robot, sensing=replace(robot.sensing, tag=(0.0, 0.0)))


NUISANCES: dict[str, Callable[[Robot], Robot]] = {
    "mass_behind": _no_mass_behind,
    "rolling": lambda robot: robot.changed(rolling=0.0),
    "caster": _no_caster,
    "asymmetry": _no_asymmetry,
    "tag": _no_tag,
}


def without(robot: Robot, name: str) -> Robot:
    """Return the robot without one of its departures."""
    return NUISANCES[name](robot)


def described(robot: Robot) -> dict[str, Any]:
    """Return what the key tells of a robot's body."""
    told = asdict(robot.plant)
    x, y, height = told.pop("centre")
    told |= {"kind": robot.kind, "centre_x": x, "centre_y": y, "centre_height": height}
    told |= {
        "caster": robot.plant.third.kind,
        "area": robot.area,
        "tick": robot.tick,
        "reverse": robot.reverse,
    }
    if robot.plant.third.kind in SLIDERS:
        told["caster_friction"] = robot.plant.third.slide
    return told
