"""People who push."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.ode_robots.engine import GRAVITY
from benchmarks.ode_robots.laws import law
from benchmarks.ode_robots.setup import Hook, Setup
from benchmarks.robot_sets.laws import Draw

if TYPE_CHECKING:
    from benchmarks.ode_robots.machine import Machine, Now


@law(
    "external_push",
    "share of weight",
    0.01,
    3.0,
    "people shove a robot aside: short pushes off its middle",
    local=True,
)
def shoves(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Half a dozen shoves a run, each a half sine of 0.2 to 0.6 s, at the robot's side."""
    weight, axle = setup.plant.mass * GRAVITY, setup.plant.axle

    def make(machine: Machine, run: int) -> Hook:
        rng = np.random.default_rng([draw.seed, run])
        begins = np.sort(rng.uniform(3.0, draw.seconds - 4.0, 7))
        acts = [
            (float(b), float(rng.uniform(0.2, 0.6)), float(rng.uniform(-3.14, 3.14)), float(rng.uniform(-0.6, 0.6)),
             float(rng.uniform(0.6, 1.3)))
            for b in begins
        ]  # fmt: skip

        def hook(now: Now) -> None:
            for begin, length, way, lever, much in acts:
                if begin <= now.t < begin + length:
                    f = size * much * weight * math.sin(math.pi * (now.t - begin) / length)
                    now.force[0] += f * math.cos(way)
                    now.force[1] += f * math.sin(way)
                    now.force[2] += f * lever * axle
                    now.touched = True

        return hook

    setup.body.append(make)
    return {"share_of_weight": size, "times": 7.0}


@law(
    "external_push",
    "share of weight",
    0.01,
    4.0,
    "a hand holds on and leads: a soft arm to a moving place",
    local=True,
)
def leading_hand(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Five times a run a hand takes hold for about a second and pulls like a damped spring."""
    weight = setup.plant.mass * GRAVITY
    length = 0.1  # m of stretch for the size

    def make(machine: Machine, run: int) -> Hook:
        rng = np.random.default_rng([draw.seed, run])
        acts = [
            (float(b), float(rng.uniform(0.7, 1.4)), *(float(v) for v in rng.uniform(-0.15, 0.15, 2)))
            for b in np.sort(rng.uniform(3.0, draw.seconds - 4.0, 6))
        ]
        held: dict[int, tuple[float, float]] = {}

        def hook(now: Now) -> None:
            for k, (begin, lasts, vx, vy) in enumerate(acts):
                if begin <= now.t < begin + lasts:
                    x, y = held.setdefault(k, (now.x, now.y))
                    stiff, age = size * weight / length, now.t - begin
                    grip = min(age / 0.2, (lasts - age) / 0.1, 1.0)
                    now.force[0] += grip * stiff * min(max(x + vx * age - now.x, -length), length)
                    now.force[1] += grip * stiff * min(max(y + vy * age - now.y, -length), length)
                    now.touched = True

        return hook

    setup.body.append(make)
    return {"pull": size, "stretch_m": length, "times": 6.0}
