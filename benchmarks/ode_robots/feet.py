"""The third points of support: skids, trailing forks with a wheel of their own, balls in sockets."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from benchmarks.ode_robots.engine import STEP, Pad
from benchmarks.ode_robots.plant import Foot

if TYPE_CHECKING:
    from benchmarks.ode_robots.machine import Machine

Standing = Callable[["Machine", Any], None]
SINK = 0.0003  # m under the load at rest
SAFE = 2.0  # friction of light parts sets in over so many steps' worth of change, that it does not overshoot


def stand(machine: Machine, foot: Foot, load: float) -> Standing:
    """Build a foot that carries a load [N] at rest; what is returned makes its contact of each step."""
    return {"skid": _skid, "fork": _fork, "ball": _ball}[foot.kind](machine, foot, load)


def _skid(machine: Machine, foot: Foot, load: float) -> Standing:
    pad = Pad(machine.world, load / SINK, load)
    slip = 0.002 / load
    pad.surface(foot.friction, foot.friction, slip, slip)
    low = -machine.middle + foot.gap

    def touch(machine: Machine, forward: Any) -> None:
        place = machine.point(foot.x, foot.y, low)
        if place[2] < 0.0:
            pad.touch(machine.chassis, place[0], place[1], -place[2], forward)

    return touch


def _fork(machine: Machine, foot: Foot, load: float) -> Standing:
    """Build a fork that swivels, with a wheel that trails behind its upright pin."""
    world, plant = machine.world, machine.plant
    r = 0.45 * machine.middle
    mass = 0.02 * plant.mass
    sign = -1.0  # starts as after a forward drive
    spot = machine.at(foot.x + sign * foot.trail, foot.y, r - machine.middle)
    small = 0.5 * mass * r * r
    fork = world.body(spot, machine.start[2], 0.5 * mass, (small, small, small))
    wheel = world.body(spot, machine.start[2], 0.5 * mass, (0.3 * small, 0.5 * small, 0.3 * small))
    pin = world.hinge(fork, machine.chassis, machine.at(foot.x, foot.y, 0.0), (0.0, 0.0, 1.0))
    swivel = foot.swivel * load * foot.trail
    roll = world.hinge(wheel, fork, spot, machine.side_axis())
    rub = foot.friction * load * r
    soft_swivel = SAFE * STEP * swivel / (small + 0.5 * mass * foot.trail**2)
    soft_rub = SAFE * STEP * rub / small
    pad = Pad(world, load / SINK, load)

    def touch(machine: Machine, forward: Any) -> None:
        place = wheel.getPosition()
        depth = r - place[2]
        pin.addTorque(-swivel * math.tanh(pin.getAngleRate() / (0.05 + soft_swivel)))
        roll.addTorque(-rub * math.tanh(roll.getAngleRate() / (0.05 + soft_rub)))
        if depth > 0.0:
            ahead = fork.vectorToWorld(1, 0, 0)
            size = math.hypot(ahead[0], ahead[1])
            v = wheel.getLinearVel()
            slip = (0.02 + math.hypot(v[0], v[1])) / (20.0 * load)
            pad.surface(0.7, 0.7, slip, slip)
            pad.touch(wheel, place[0], place[1], depth, ahead / size)

    return touch


def _ball(machine: Machine, foot: Foot, load: float) -> Standing:
    """Build a ball in a socket that rubs: a sphere on a ball joint, held by friction in it."""
    world = machine.world
    r = 0.35 * machine.middle
    mass = 0.015 * machine.plant.mass
    spin = 0.4 * mass * r * r
    spot = machine.at(foot.x, foot.y, r - machine.middle + foot.gap)
    ball = world.body(spot, machine.start[2], mass, (spin, spin, spin))
    world.ball(ball, machine.chassis, spot)
    rub = foot.friction * load * r
    soft = 0.05 + SAFE * STEP * rub / spin
    pad = Pad(world, load / SINK, load)
    slip = 0.002 / load
    pad.surface(0.6, 0.6, slip, slip)

    def touch(machine: Machine, forward: Any) -> None:
        place = ball.getPosition()
        depth = r - place[2]
        turns = ball.getAngularVel() - machine.spin
        size = turns.length()
        if size > 1e-6:
            moment = turns * (-rub * math.tanh(size / soft) / size)
            ball.addTorque(moment)
            machine.chassis.addTorque(-moment)
        if depth > 0.0:
            pad.touch(ball, place[0], place[1], depth, forward)

    return touch
