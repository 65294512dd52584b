"""Physics that no label names: what pulls, carries or lifts a robot from outside."""

from __future__ import annotations

import math

from benchmarks.box2d_robots.laws import law
from benchmarks.box2d_robots.laws_floor import felt_by_wheels, strip_of
from benchmarks.box2d_robots.machine import Machine, Now
from benchmarks.box2d_robots.parts import Hook, Setup
from benchmarks.box2d_robots.robots import full_speed
from benchmarks.robot_sets.laws import OUTSIDE, Draw


def _weight(setup: Setup) -> float:
    return setup.plant.mass * 9.81


@law(
    OUTSIDE,
    "tether",
    (0.005, 1.5),
    "1",
    "a supply cable hangs from a hook: slack near it, it pulls at its plug when taut",
)
def tether(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    at, far = draw.between(0, -math.pi, math.pi), draw.between(1, 0.2, 0.8) * draw.area
    hx, hy, slack = far * math.cos(at), far * math.sin(at), 0.35 * draw.area
    plug = -0.35 * setup.plant.axle

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            rx, ry = now.to_body(hx - now.x, hy - now.y)
            rx -= plug
            length = math.hypot(rx, ry)
            if length > slack:
                pull = size * _weight(setup) * (length - slack) / draw.area / length
                now.push += (pull * rx, pull * ry, plug * pull * ry)

        return hook

    setup.body.append(make)
    return {"pull_over_weight": size, "hook_x": hx, "hook_y": hy, "slack_m": slack}


@law(
    OUTSIDE,
    "swinging_fan",
    (0.0006, 0.8),
    "1",
    "a room fan swings to and fro: wind that comes and goes, from a side that turns",
)
def swinging_fan(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    at, period = draw.between(0, -math.pi, math.pi), draw.between(1, 3.0, 8.0)

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            wave = math.sin(2.0 * math.pi * now.t / period + run)
            force, way = size * _weight(setup) * math.exp(-2.0 * wave * wave), at + 0.6 * wave
            fx, fy = now.to_body(force * math.cos(way), force * math.sin(way))
            sail = -0.1 * setup.plant.axle
            now.push += (fx, fy, sail * fy)

        return hook

    setup.body.append(make)
    return {"force_over_weight": size, "from_rad": at, "period_s": period}


@law(
    OUTSIDE,
    "door_threshold",
    (0.005, 0.8),
    "1",
    "a rounded strip across the floor: each wheel climbs it and rolls down",
    local=True,
)
def door_threshold(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    (x0, y0), at = draw.spots[0], draw.between(1, 0.0, math.pi)
    nx, ny = -math.sin(at), math.cos(at)
    radius = setup.plant.radius[0]
    half, height = 1.5 * radius, size * radius

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            s, c = math.sin(now.yaw), math.cos(now.yaw)
            fx, fy = now.to_body(nx, ny)
            for k in (0, 1):
                y = float(now.track[k])
                off = (nx * (now.x - s * y - x0) + ny * (now.y + c * y - y0)) / half
                if abs(off) < 1.0:
                    now.touched = True
                    rise = -0.5 * math.pi * height / half * math.sin(math.pi * off)
                    push = -float(now.load[k]) * rise
                    now.push += (push * fx, push * fy, -y * push * fx)

        return hook

    setup.body.append(make)
    return {"height_m": height, "x_m": x0, "y_m": y0, "along_rad": at}


@law(
    OUTSIDE,
    "magnet_strip",
    (0.002, 3.0),
    "1",
    "a magnet under the nose meets a steel rail below the floor, which pulls it over itself",
    local=True,
)
def magnet_strip(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    (x0, y0), at = draw.spots[0], draw.between(1, 0.0, math.pi)
    nx, ny, nose, wide = -math.sin(at), math.cos(at), 0.4 * setup.plant.axle, 0.12 * draw.area

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            x, y = now.x + nose * math.cos(now.yaw), now.y + nose * math.sin(now.yaw)
            off = (nx * (x - x0) + ny * (y - y0)) / wide
            if abs(off) < 2.2:
                now.touched = True
                force = -size * _weight(setup) * off * math.exp(-off * off)
                fx, fy = now.to_body(force * nx, force * ny)
                now.push += (fx, fy, nose * fy)

        return hook

    setup.body.append(make)
    return {"pull_over_weight": size, "x_m": x0, "y_m": y0, "along_rad": at}


@law(
    OUTSIDE,
    "conveyor",
    (0.0008, 1.2),
    "1",
    "a belt in the floor runs on slowly and carries each wheel that stands on it",
    local=True,
)
def conveyor(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    where, sizes = strip_of(draw)
    at, speed = sizes["along_rad"], size * full_speed(setup.plant, setup.control)

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            vx, vy = now.to_body(speed * math.cos(at), speed * math.sin(at))
            for k, there in enumerate(felt_by_wheels(now, where)):
                now.floor_x[k] += there * vx
                now.floor_y[k] += there * vy

        return hook

    setup.floor.append(make)
    return sizes | {"speed_m_s": speed}


@law(
    OUTSIDE,
    "suction_fan",
    (0.0006, 0.8),
    "1",
    "a blower's nozzle on the hull pushes it all the time, beside the middle",
)
def suction_fan(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    at, arm = draw.between(0, -math.pi, math.pi), draw.between(1, -0.5, 0.5) * setup.plant.axle
    force = size * _weight(setup)
    push = (force * math.cos(at), force * math.sin(at), force * arm)

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            now.push += push

        return hook

    setup.body.append(make)
    return {"force_N": force, "direction_rad": at, "arm_m": arm}
