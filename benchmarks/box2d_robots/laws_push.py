"""Laws of pushes from outside."""

from __future__ import annotations

import math

import Box2D
import numpy as np

from benchmarks.box2d_robots.laws import law
from benchmarks.box2d_robots.machine import Machine, Now
from benchmarks.box2d_robots.parts import Hook, Setup
from benchmarks.robot_sets.laws import Draw


def _moments(seed: int, run: int, every: float) -> list[float]:
    """Return moments [s] in the order of time, `every` s apart within half of that."""
    rng = np.random.default_rng([seed, run, 3])
    count = int(75.0 / every)
    return [2.0 + every * (k + float(rng.uniform(0.0, 0.5))) for k in range(count)]


def _weight(setup: Setup) -> float:
    return setup.plant.mass * 9.81


@law(
    "external_push",
    "kicks",
    (0.01, 2.0),
    "1",
    "somebody's foot: a half sine of a third of a second, from any side, not through the middle",
    local=True,
)
def kicks(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    most, lasts = size * _weight(setup), draw.between(0, 0.2, 0.45)

    def make(machine: Machine, run: int) -> Hook:
        rng, times = np.random.default_rng([draw.seed, run]), _moments(draw.seed, run, 5.0)
        what = [0.0, 0.0, 0.0]

        def hook(now: Now) -> None:
            if not times or now.t < times[0]:
                return
            if what[2] == 0.0:
                what[0] = float(rng.uniform(-math.pi, math.pi))
                what[1] = float(rng.uniform(-0.5, 0.5)) * setup.plant.axle
                what[2] = float(rng.uniform(0.6, 1.0))
            at = (now.t - times[0]) / lasts
            if at >= 1.0:
                times.pop(0)
                what[2] = 0.0
                return
            now.touched = True
            force = most * what[2] * math.sin(math.pi * at)
            fx, fy = now.to_body(force * math.cos(what[0]), force * math.sin(what[0]))
            now.push += (fx, fy, what[1] * force)

        return hook

    setup.body.append(make)
    return {"force_N": most, "lasts_s": lasts}


@law(
    "external_push",
    "leaning_dog",
    (0.005, 1.0),
    "1",
    "an animal leans on the hull for a second or two: a steady force that comes and goes with a ramp",
    local=True,
)
def leaning_dog(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    most = size * _weight(setup)

    def make(machine: Machine, run: int) -> Hook:
        rng, times = np.random.default_rng([draw.seed, run]), _moments(draw.seed, run, 8.0)
        plan = [(t, t + float(rng.uniform(1.0, 2.2)), float(rng.uniform(-math.pi, math.pi))) for t in times]

        def hook(now: Now) -> None:
            while plan and now.t > plan[0][1]:
                plan.pop(0)
            if not plan or now.t < plan[0][0]:
                return
            now.touched = True
            begin, end, at = plan[0]
            force = most * min(1.0, (now.t - begin) / 0.3, (end - now.t) / 0.2)
            fx, fy = now.to_body(force * math.cos(at), force * math.sin(at))
            now.push += (fx, fy, 0.3 * setup.plant.axle * force * math.sin(3.0 * at))

        return hook

    setup.body.append(make)
    return {"force_N": most}


@law(
    "external_push",
    "thrown_balls",
    (0.05, 15.0),
    "m/s",
    "balls roll into the hull: the engine's own collisions, with restitution and friction",
    local=True,
)
def thrown_balls(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    heavy, wide = draw.between(0, 0.04, 0.15) * setup.plant.mass, 0.15 * setup.plant.axle

    def make(machine: Machine, run: int) -> Hook:
        rng, times = np.random.default_rng([draw.seed, run]), _moments(draw.seed, run, 4.0)
        ball: list[Box2D.b2Body] = []

        def throw(now: Now) -> None:
            at, off = float(rng.uniform(-math.pi, math.pi)), float(rng.uniform(-0.3, 0.3))
            c, s, far = math.cos(at), math.sin(at), 1.2 * setup.plant.axle
            place = (now.x + far * c - off * wide * s, now.y + far * s + off * wide * c)
            v = machine.body.linearVelocity
            ball.append(machine.world.CreateDynamicBody(position=place, bullet=True))
            ball[0].CreateCircleFixture(radius=wide, density=1.0, friction=0.3, restitution=0.4)
            ball[0].massData = Box2D.b2MassData(mass=heavy, center=(0.0, 0.0), I=0.5 * heavy * wide**2)
            ball[0].linearVelocity = (v.x - size * c, v.y - size * s)

        def hook(now: Now) -> None:
            if not times or now.t < times[0]:
                return
            now.touched = True
            if not ball:
                throw(now)
            elif now.t > times[0] + 0.7:
                machine.world.DestroyBody(ball.pop())
                times.pop(0)

        return hook

    setup.body.append(make)
    return {"speed_m_s": size, "mass_kg": heavy}
