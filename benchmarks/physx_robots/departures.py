"""Small imperfections that every robot has and no label names, and the data sheet that is a little off."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.physx_robots.robots import Rng, Robot, change_motors

Change = Callable[[Rng, Robot], tuple[Robot, float]]


def _radii(rng: Rng, robot: Robot) -> tuple[Robot, float]:
    share = float(rng.uniform(0.001, 0.004)) * float(rng.choice([-1, 1]))
    left, right = (replace(w, radius=w.radius * (1 + s * share)) for w, s in zip(robot.wheels, (1, -1)))
    return replace(robot, wheels=(left, right)), 2 * share


def _unlike(rng: Rng, robot: Robot) -> tuple[Robot, float]:
    share = float(rng.uniform(0.005, 0.02)) * float(rng.choice([-1, 1]))
    left, right = (
        replace(m, free=m.free * (1 + s * share), stall=m.stall * (1 + s * share))
        for m, s in zip(robot.motors, (1, -1))
    )
    return replace(robot, motors=(left, right)), 2 * share


def _rolling(rng: Rng, robot: Robot) -> tuple[Robot, float]:
    rolling = float(rng.uniform(0.003, 0.006))
    return replace(robot, rolling=rolling), rolling


def _viscous(rng: Rng, robot: Robot) -> tuple[Robot, float]:
    share = float(rng.uniform(0.003, 0.015))
    return change_motors(robot, lambda m: replace(m, viscous=share * m.stall / m.free)), share


def _curve(rng: Rng, robot: Robot) -> tuple[Robot, float]:
    bend = float(rng.uniform(0.004, 0.012)) * float(rng.choice([-1, 1]))
    return replace(robot, bend=bend), bend


def _asymmetry(rng: Rng, robot: Robot) -> tuple[Robot, float]:
    share = float(rng.uniform(0.002, 0.006))
    return change_motors(robot, lambda m: replace(m, reverse_free=1 - share)), share


def _caster(rng: Rng, robot: Robot) -> tuple[Robot, float]:
    more = float(rng.uniform(0.004, 0.012))
    return replace(robot, casters=tuple(replace(c, friction=c.friction + more) for c in robot.casters)), more


def _tag(rng: Rng, robot: Robot) -> tuple[Robot, float]:
    angle, size = rng.uniform(-np.pi, np.pi), float(rng.uniform(0.001, 0.002))
    tag = (float(size * np.cos(angle)), float(size * np.sin(angle)))
    yaw = float(rng.uniform(-0.005, 0.005))
    return replace(robot, sensing=replace(robot.sensing, tag=tag, tag_yaw=yaw)), size


def _uneven(rng: Rng, robot: Robot) -> tuple[Robot, float]:
    angle, size = rng.uniform(-np.pi, np.pi), float(rng.uniform(0.0002, 0.0006))
    return replace(robot, tilt=(float(size * np.cos(angle)), float(size * np.sin(angle)))), size


CHANGES: dict[str, Change] = {
    "radii": _radii,
    "motors": _unlike,
    "rolling": _rolling,
    "viscous": _viscous,
    "curve": _curve,
    "asymmetry": _asymmetry,
    "caster": _caster,
    "tag": _tag,
    "uneven_floor": _uneven,
}
UNLIKE = ("radii", "motors")  # what two gains take up
DUTY_ONLY = ("motors", "viscous", "curve", "asymmetry")


def add_departures(rng: Rng, robot: Robot, more_mass: float) -> tuple[Robot, Robot]:
    """Return the robot with the mass off the axle that it stands by and one to three more departures, and the
    same with none but wheels or motors that are unlike; more_mass: share by which the data sheet's mass is too
    small.
    """
    found = {"mass_behind": abs(robot.centre[0])}
    names = [n for n in CHANGES if not (robot.controller and n in DUTY_ONLY)]
    names = [n for n in names if not (n == "caster" and robot.casters[0].kind != "ball")]
    if robot.casters[0].kind != "ball":
        found["caster"] = (
            robot.casters[0].friction if robot.casters[0].kind == "skid" else robot.casters[0].trail
        )
    bare = robot
    for name in rng.choice(names, size=int(rng.integers(1, 4)), replace=False):
        state = int(rng.integers(2**31))
        robot, found[str(name)] = CHANGES[str(name)](np.random.default_rng(state), robot)
        if name in UNLIKE:
            bare = CHANGES[str(name)](np.random.default_rng(state), bare)[0]
    if more_mass > 0:
        found["more_mass"] = more_mass
    return replace(robot, departures=found), bare


def loaded_rate(robot: Robot) -> float:
    """Return the wheel rate [rad/s] at command 1 on a level floor, of the mean motor."""
    if robot.controller:
        return robot.full_rate
    rates = []
    for motor, load, wheel in zip(robot.motors, robot.loads, robot.wheels):
        dry = motor.coulomb + robot.rolling * load * wheel.radius
        rates.append(motor.free * (1 - dry / motor.stall) / (1 + motor.viscous * motor.free / motor.stall))
    return float(np.mean(rates))


def data_sheet(rng: Rng, drawn: Robot) -> tuple[Robot, Robot]:
    """Return the robot with departures, and without, and the facts that its owner knows: each off by 1 to 4 %."""
    excess = float(rng.uniform(0.02, 0.08)) if rng.random() < 0.3 else 0.0
    robot, bare = add_departures(rng, drawn, excess)

    def off() -> float:
        return float(1 + rng.choice([-1, 1]) * rng.uniform(0.01, 0.04))

    facts = {
        "wheel_radius": robot.radius * off(),
        "axle_length": robot.axle * off(),
        "max_wheel_rate": loaded_rate(robot) * off(),
        "mass": robot.total_mass * (1 - excess if excess else off()),
    }
    told: dict[str, Any] = {"full_rate": facts["max_wheel_rate"], "facts": facts}
    return replace(robot, **told), replace(bare, **told)


def smooth(robot: Robot) -> Robot:
    """Return the robot almost without the dry friction that each has."""
    return change_motors(
        replace(robot, rolling=0.1 * robot.rolling), lambda m: replace(m, coulomb=0.1 * m.coulomb)
    )


def with_friction_told(robot: Robot) -> Robot:
    """Return the robot with its dry friction, as a coefficient of rolling resistance, among its departures."""
    sides = zip(robot.motors, robot.loads, robot.wheels)
    drag = float(np.mean([m.coulomb / (load * wheel.radius) for m, load, wheel in sides])) + robot.rolling
    return replace(robot, departures={"rolling": drag} | robot.departures)
