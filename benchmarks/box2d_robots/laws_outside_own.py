"""Physics that no label names, of the robot itself: its leads, wheels, gyro, and what it tows."""

from __future__ import annotations

import math

import Box2D

from benchmarks.box2d_robots.laws import law
from benchmarks.box2d_robots.machine import Machine, Now
from benchmarks.box2d_robots.parts import Hook, Setup
from benchmarks.box2d_robots.robots import full_speed
from benchmarks.robot_sets.laws import OUTSIDE, Draw


@law(
    OUTSIDE,
    "toed_wheels",
    (0.004, 0.6),
    "rad",
    "bent brackets: the wheels do not point straight ahead, nor alike",
)
def toed_wheels(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    left, right = size * draw.sign(0), size * draw.between(1, -0.3, 0.8) * draw.sign(0)

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            now.toe[0], now.toe[1] = left, right

        return hook

    setup.floor.append(make)
    return {"left_rad": left, "right_rad": right}


@law(
    OUTSIDE,
    "ground_bounce",
    (0.02, 3.0),
    "1",
    "a thin ground lead: one motor's current shifts what the other's driver takes for zero",
    ("duty",),
)
def ground_bounce(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    stall, share = setup.plant.volts / setup.plant.winding[0], draw.between(0, -0.6, 0.6)

    def make(machine: Machine, run: int) -> Hook:
        lagged = [0.0, 0.0]

        def hook(now: Now) -> None:
            for k in (0, 1):
                lagged[k] += 0.1 * (float(now.amps[k]) / stall - lagged[k])
            now.duty[0] += size * share * lagged[1]
            now.duty[1] += size * lagged[0]

        return hook

    setup.drive.append(make)
    return {"onto_right": size, "onto_left": size * share}


@law(
    OUTSIDE,
    "brown_outs",
    (0.01, 1.2),
    "s",
    "surges pull the logic supply down: the board resets and is dead for a while",
    ("duty",),
    True,
)
def brown_outs(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    surge = 0.45 * 2.0 * setup.plant.volts / setup.plant.winding[0]

    def make(machine: Machine, run: int) -> Hook:
        dead = [-9.0]

        def hook(now: Now) -> None:
            drawn = abs(float(now.amps[0])) + abs(float(now.amps[1]))
            if drawn > surge and now.t > dead[0] + 1.5:
                dead[0] = now.t + size
            if now.t < dead[0]:
                now.duty[:] = 0.0
            if now.t < dead[0] + 0.3:
                now.touched = True

        return hook

    setup.drive.append(make)
    return {"dead_s": size, "surge_A": surge}


@law(
    OUTSIDE,
    "trailer",
    (0.01, 2.5),
    "1",
    "a small trailer on a hitch: a body and a joint of the engine, wheels that hold sideways",
)
def trailer(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    axle = setup.plant.axle
    hitch, pole, heavy = -0.6 * axle, draw.between(0, 0.7, 1.2) * axle, size * setup.plant.mass

    def make(machine: Machine, run: int) -> Hook:
        now = machine.now
        c, s = math.cos(now.yaw), math.sin(now.yaw)
        at, axis = hitch - pole, (now.x + hitch * c, now.y + hitch * s)
        body = machine.world.CreateDynamicBody(position=(now.x + at * c, now.y + at * s), angle=now.yaw)
        body.massData = Box2D.b2MassData(mass=heavy, center=(0.0, 0.0), I=heavy * (0.35 * axle) ** 2)
        machine.world.CreateRevoluteJoint(bodyA=machine.body, bodyB=body, anchor=axis)

        def hook(now: Now) -> None:
            v, a = body.linearVelocity, body.angle
            c, s = math.cos(a), math.sin(a)
            along, across = c * v.x + s * v.y, c * v.y - s * v.x
            roll = -0.02 * heavy * 9.81 * math.tanh(along / 0.01)
            hold = -min(max(60.0 * heavy * across, -6.0 * heavy), 6.0 * heavy)
            body.ApplyForceToCenter((c * roll - s * hold, s * roll + c * hold), True)

        return hook

    setup.body.append(make)
    return {"mass_kg": heavy, "pole_m": pole}


@law(
    OUTSIDE,
    "leaking_tyre",
    (0.005, 0.5),
    "1",
    "one tyre loses air: its rolling radius shrinks all the time of a run",
)
def leaking_tyre(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    side = int(draw.numbers[0] < 0.5)

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            gone = min(now.t / 60.0, 1.2)
            now.radius[side] *= 1.0 - size * gone
            now.roll[side] += 0.1 * size * gone

        return hook

    setup.floor.append(make)
    return {"lost_in_60_s": size, "right": float(side)}


@law(
    OUTSIDE,
    "gyro_assist",
    (0.02, 6.0),
    "1",
    "the base steers against what its gyro feels beyond the turn that was asked for",
    ("duty",),
)
def gyro_assist(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    speed = full_speed(setup.plant, setup.control)

    def make(machine: Machine, run: int) -> Hook:
        felt = [0.0]

        def hook(now: Now) -> None:
            felt[0] += now.step / 0.03 * (float(now.motion[2]) - felt[0])
            off = 0.5 * (now.command[1] - now.command[0]) - 0.5 * felt[0] * setup.plant.axle / speed
            now.duty[0] = min(max(float(now.duty[0]) - size * off, -1.0), 1.0)
            now.duty[1] = min(max(float(now.duty[1]) + size * off, -1.0), 1.0)

        return hook

    setup.drive.append(make)
    return {"gain": size}
