"""Physics that no label names."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from benchmarks.ode_robots.engine import GRAVITY
from benchmarks.ode_robots.laws import law
from benchmarks.ode_robots.setup import Hook, Setup
from benchmarks.robot_sets.laws import OUTSIDE, Draw

if TYPE_CHECKING:
    from benchmarks.ode_robots.machine import Machine, Now


@law(
    OUTSIDE,
    "share of mass",
    0.02,
    1.5,
    "a one-axle trailer on a hitch: a body on a hinge, its wheels do not yield",
)
def trailer(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """A towed body; at its axle it moves only where it points, with some rolling resistance."""
    axle = setup.plant.axle
    hitch, pole, mass = -0.6 * axle, draw.between(0, 0.7, 1.2) * axle, size * setup.plant.mass

    def make(machine: Machine, run: int) -> Hook:
        inertia = mass * (0.4 * axle) ** 2
        cart = machine.world.body(machine.at(hitch - pole, 0.0, 0.0), machine.start[2], mass, (inertia,) * 3)
        cart.setGravityMode(False)  # its own wheels carry it
        machine.world.hinge(cart, machine.chassis, machine.at(hitch, 0.0, 0.0), (0.0, 0.0, 1.0))

        def hook(now: Now) -> None:
            f, v = cart.vectorToWorld(1, 0, 0), cart.getLinearVel()
            along, across = v[0] * f[0] + v[1] * f[1], v[1] * f[0] - v[0] * f[1]
            side = -mass * 0.8 * GRAVITY * math.tanh(across / 0.05)
            back = -mass * 0.02 * GRAVITY * math.tanh(along / 0.02)
            cart.addForce(back * f[0] - side * f[1], back * f[1] + side * f[0], 0.0)

        return hook

    setup.body.append(make)
    return {"mass_kg": mass, "pole_m": pole}


@law(
    OUTSIDE,
    "share of weight",
    0.005,
    1.5,
    "an elastic leash to a post: slack near it, then stiffer with stretch",
)
def bungee(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Pulls towards a post beyond a slack length, at the tail of the robot."""
    at, far = draw.between(0, -math.pi, math.pi), draw.between(1, 0.0, 0.6) * draw.area
    px, py, slack = far * math.cos(at), far * math.sin(at), 0.35 * draw.area
    weight, axle = setup.plant.mass * GRAVITY, setup.plant.axle

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            tail = -0.4 * axle
            dx, dy = px - now.x - tail * now.c, py - now.y - tail * now.s
            d = math.hypot(dx, dy)
            if d > slack:
                f = size * weight * (d - slack) / draw.area / d
                now.force[0] += f * dx
                now.force[1] += f * dy
                now.force[2] += tail * f * (now.c * dy - now.s * dx)

        return hook

    setup.body.append(make)
    return {"pull": size, "post_x": px, "post_y": py, "slack_m": slack}


@law(
    OUTSIDE, "share of weight", 0.01, 3.0, "steel under the floor draws the magnets of the motors", local=True
)
def buried_steel(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Two places draw the robot's nose towards their middle, strongest at a hand's breadth."""
    weight, reach, axle = setup.plant.mass * GRAVITY, 0.15 * draw.area, setup.plant.axle

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            nose = 0.4 * axle
            for a, b in draw.spots:
                dx, dy = a - now.x - nose * now.c, b - now.y - nose * now.s
                q = (dx * dx + dy * dy) / reach**2
                if q < 12.0:
                    f = size * weight / reach / (1.0 + q) ** 2
                    now.force[0] += f * dx
                    now.force[1] += f * dy
                    now.force[2] += nose * f * (now.c * dy - now.s * dx)
                    now.touched = now.touched or q < 6.0

        return hook

    setup.body.append(make)
    return {"draw": size, "reach_m": reach}


@law(
    OUTSIDE,
    "share of mass",
    0.03,
    1.5,
    "water in an open tray: its first mode as a mass on springs (Abramson 1966)",
)
def sloshing_tray(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """A mass that swings along and across the robot at 0.8 to 2 Hz with 4 % damping."""
    w, axle = 2.0 * math.pi * draw.between(0, 0.8, 2.0), setup.plant.axle
    mass, most = size * setup.plant.mass, 0.35 * setup.plant.axle

    def make(machine: Machine, run: int) -> Hook:
        at, speed, last = [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]

        def hook(now: Now) -> None:
            v = machine.chassis.getLinearVel()
            for k in (0, 1):  # in the room, against the robot
                pull = w * w * at[k] * (1.0 + (at[k] / most) ** 2) + 0.08 * w * speed[k]
                speed[k] += -pull * now.step - (v[k] - last[k])
                at[k] = min(max(at[k] + speed[k] * now.step, -axle), axle)
                last[k] = v[k]
                now.force[k] += mass * pull

        return hook

    setup.body.append(make)
    return {"mass_kg": mass, "rate_hz": w / 2.0 / math.pi}


@law(OUTSIDE, "share of weight", 0.002, 0.8, "a desk fan that swings: wind on the robot's broad sides")
def swinging_fan(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """A jet from a corner that sweeps to and fro in 8 to 14 s and pushes broad sides more than the nose."""
    at, period = draw.between(0, -math.pi, math.pi), draw.between(1, 8.0, 14.0)
    fx, fy = 2.2 * draw.area * math.cos(at), 2.2 * draw.area * math.sin(at)
    weight, axle = setup.plant.mass * GRAVITY, setup.plant.axle

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            aim = at + math.pi + 0.5 * math.sin(2.0 * math.pi * now.t / period + 1.7 * run)
            way = math.atan2(now.y - fy, now.x - fx)
            off = math.remainder(way - aim, 2.0 * math.pi)
            d = math.hypot(now.x - fx, now.y - fy) / (2.2 * draw.area)
            across = math.sin(way - now.yaw)
            f = size * weight * math.exp(-((off / 0.3) ** 2)) / (0.3 + d) * (0.6 + 0.4 * across**2)
            now.force[0] += f * math.cos(way)
            now.force[1] += f * math.sin(way)
            now.force[2] += 0.15 * axle * f * math.sin(2.0 * (way - now.yaw))

        return hook

    setup.body.append(make)
    return {"push": size, "period_s": period}


@law(
    OUTSIDE,
    "share of mass",
    0.03,
    1.2,
    "a can that rolls to and fro on the deck: a body on a slide with stops",
)
def rolling_can(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """A body that slides freely across the deck between two stops, thrown about by turns and starts."""
    reach, skew = draw.between(0, 0.15, 0.3) * setup.plant.axle, draw.between(1, 0.2, 1.3)
    mass = size * setup.plant.mass

    def make(machine: Machine, run: int) -> Hook:
        inertia = mass * 0.02 * setup.plant.axle**2
        can = machine.world.body(
            machine.at(0.0, 0.0, 0.5 * machine.middle), machine.start[2], mass, (inertia,) * 3
        )
        yaw = machine.start[2] + skew
        slide = machine.world.slider(can, machine.chassis, (math.cos(yaw), math.sin(yaw), 0.0))
        slide.setParamLoStop(-reach)
        slide.setParamHiStop(reach)
        slide.setParamBounce(0.3)

        def hook(now: Now) -> None:
            slide.addForce(-0.02 * mass * GRAVITY * math.tanh(slide.getPositionRate() / 0.05))

        return hook

    setup.body.append(make)
    return {"mass_kg": mass, "reach_m": reach, "axis_rad": skew}


@law(
    OUTSIDE,
    "share of weight",
    0.004,
    1.2,
    "a mains cable that is dragged: the further out, the more of it slides",
)
def dragged_cable(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Friction of the length on the floor, against the tail's motion, and a spring of its bends to the socket."""
    at = draw.between(0, -math.pi, math.pi)
    sx, sy = 1.5 * draw.area * math.cos(at), 1.5 * draw.area * math.sin(at)
    weight, tail = setup.plant.mass * GRAVITY, -0.5 * setup.plant.axle

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            tx, ty = now.x + tail * now.c, now.y + tail * now.s
            dx, dy = (sx - tx) / draw.area, (sy - ty) / draw.area
            d = math.hypot(dx, dy)
            vx = now.speed * now.c - tail * now.turn * now.s
            vy = now.speed * now.s + tail * now.turn * now.c
            v = math.hypot(vx, vy) + 0.02
            fx = size * weight * (0.2 * d * dx / (d + 0.1) - 0.3 * d * vx / v)
            fy = size * weight * (0.2 * d * dy / (d + 0.1) - 0.3 * d * vy / v)
            now.force[0] += fx
            now.force[1] += fy
            now.force[2] += tail * (now.c * fy - now.s * fx)

        return hook

    setup.body.append(make)
    return {"size": size, "socket_x": sx, "socket_y": sy}
