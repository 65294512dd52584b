"""A robot of bodies, hinges and contacts in the Open Dynamics Engine, one step at a time."""

from __future__ import annotations

import math
from typing import Any

from panda3d.core import Vec3  # type: ignore[import-not-found,import-untyped,unused-ignore]

from benchmarks.ode_robots.bristle import Bristle
from benchmarks.ode_robots.controller import Controller
from benchmarks.ode_robots.engine import GRAVITY, STEP, Pad, World
from benchmarks.ode_robots.feet import stand
from benchmarks.ode_robots.setup import Hook, Setup

SINK = 0.0002  # m that a wheel sinks in under its load
LYING = 0.4  # upward part of the axle's direction from which on a robot has fallen over


class Now:
    """What a step knows and what laws may change in it; lists are left and right."""

    def __init__(self, step: float) -> None:
        """Begin at rest."""
        self.step = step
        self.t = self.x = self.y = self.yaw = self.speed = self.turn = 0.0
        self.c, self.s = 1.0, 0.0
        self.told = [0.0, 0.0]  # command as logged
        self.command = [0.0, 0.0]  # command as it arrives
        self.duty = [0.0, 0.0]
        self.supply = 1.0
        self.rate, self.angle = [0.0, 0.0], [0.0, 0.0]  # of the motors, at the wheel [rad/s, rad]
        self.torque, self.dry = [0.0, 0.0], [0.0, 0.0]  # N m
        self.spots = [(0.0, 0.0), (0.0, 0.0)]  # where the wheels stand [m]
        self.load = [0.0, 0.0]  # N at rest
        self.grip = [1.0, 1.0]  # share of the floor's friction
        self.grip_across = [1.0, 1.0]
        self.yielding = [1.0, 1.0]  # share of the tyres' creep, along
        self.yielding_across = [1.0, 1.0]
        self.film = [0.0, 0.0]  # m/s of slip for a load's worth of force
        self.ahead = [0.0, 0.0]  # m by which the floor's push moves ahead of the wheel
        self.drift = [(0.0, 0.0), (0.0, 0.0)]  # m/s of the floor's surface, along and across the wheel
        self.slope = (0.0, 0.0)  # rad, downhill along x and y
        self.force = [0.0, 0.0, 0.0]  # N, N at the axle's middle in the room, N m
        self.touched = False


class Machine:
    """The bodies of one run."""

    def __init__(self, setup: Setup, run: int, start: tuple[float, float, float], step: float = STEP) -> None:
        """Set the robot down at start (x, y, yaw) [m, m, rad]."""
        plant = setup.plant
        self.setup, self.plant, self.start = setup, plant, start
        self.world = World(step)
        self.now = Now(step)
        self.middle = 0.5 * (plant.radius[0] + plant.radius[1])
        self.control = Controller(setup.robot.control, step) if setup.robot.control else None
        body_mass = plant.mass - 2 * plant.wheel_mass
        k = plant.gyration**2 * body_mass
        self.chassis = self.world.body(self.at(*plant.centre), start[2], body_mass, (0.6 * k, 0.7 * k, k))
        self.hinges: list[Any] = []
        self.wheels: list[Any] = []
        self.rotors: list[Any] = []
        for side in (0, 1):
            self._wheel(side)
        reach = max((abs(foot.x) for foot in plant.feet if foot.x * plant.centre[0] >= 0), default=1.0)
        on_feet = min(abs(plant.centre[0]) / max(reach, 1e-3), 0.8)
        weight = plant.mass * GRAVITY
        self.load = 0.5 * weight * (1.0 - on_feet)
        hard = self.load / SINK
        self.pads = [
            [Pad(self.world, hard / len(t.tracks), self.load) for _ in t.tracks] for t in setup.tyres
        ]
        self.feet = [stand(self, foot, max(on_feet, 0.05) * weight) for foot in plant.feet]
        effective = plant.rotor + 0.4 * plant.mass * self.middle**2
        self.bristles = [Bristle(STEP, step, effective, plant.rotor, dry) for dry in plant.dry]
        self.stages: list[list[Hook]] = []
        for made in (setup.command, setup.supply, setup.motor, setup.floor, setup.body):
            hooks = [factory(self, run) for factory in made]
            self.stages.append([hook for hook in hooks if hook is not None])
        self.now.yaw = start[2]
        self._see()

    def at(self, x: float, y: float, z: float) -> tuple[float, float, float]:
        """Return the place in the room of a point of the robot at its start, from the axle's middle."""
        c, s = math.cos(self.start[2]), math.sin(self.start[2])
        return self.start[0] + c * x - s * y, self.start[1] + s * x + c * y, self.middle + z

    def side_axis(self) -> tuple[float, float, float]:
        """Return the direction of the axle at the start."""
        return -math.sin(self.start[2]), math.cos(self.start[2]), 0.0

    def _wheel(self, side: int) -> None:
        plant, play = self.plant, self.setup.play
        r, m = plant.radius[side], plant.wheel_mass
        place = self.at(0.0, plant.axle * (0.5 - side), 0.0)
        about, spin = 0.27 * m * r**2, 0.5 * m * r**2
        inner = 0.0 if play is None else 0.8 * plant.rotor
        wheel = self.world.body(place, self.start[2], m, (about, spin + plant.rotor - inner, about))
        self.wheels.append(wheel)
        self.hinges.append(self.world.hinge(wheel, self.chassis, place, self.side_axis()))
        if play is not None:
            small = (0.5 * inner, inner, 0.5 * inner)
            rotor = self.world.body(place, self.start[2], 0.05 * m, small)
            mesh = self.world.hinge(rotor, wheel, place, self.side_axis())
            mesh.setParamLoStop(-play.half[side])
            mesh.setParamHiStop(play.half[side])
            mesh.setParamStopERP(play.erp)
            mesh.setParamStopCFM(play.cfm)
            self.rotors.append(rotor)

    def point(self, x: float, y: float, z: float) -> Any:
        """Return where a point of the robot is, from the axle's middle."""
        cx, cy, cz = self.plant.centre
        return self.chassis.getRelPointPos(x - cx, y - cy, z - cz)

    def _see(self) -> None:
        now, chassis = self.now, self.chassis
        place = self.point(0.0, 0.0, 0.0)
        f = chassis.vectorToWorld(1, 0, 0)
        size = math.hypot(f[0], f[1])
        now.c, now.s = f[0] / size, f[1] / size
        turned = math.atan2(now.s, now.c) - now.yaw
        now.yaw += turned - 2.0 * math.pi * round(turned / (2.0 * math.pi))
        now.x, now.y = place[0], place[1]
        v, self.spin = chassis.getLinearVel(), chassis.getAngularVel()
        now.speed, now.turn = v[0] * now.c + v[1] * now.s, self.spin[2]
        a = chassis.vectorToWorld(0, 1, 0)
        self.axis = (a[0], a[1], a[2])
        for side in (0, 1):
            if self.rotors:
                w = self.rotors[side].getAngularVel() - self.spin
                now.rate[side] = w[0] * a[0] + w[1] * a[1] + w[2] * a[2]
            else:
                now.rate[side] = self.hinges[side].getAngleRate()

    @property
    def motors(self) -> tuple[float, float]:
        """How far the motors have turned [rad]."""
        return self.now.angle[0], self.now.angle[1]

    @property
    def has_fallen(self) -> bool:
        """Whether the robot lies on its side."""
        return abs(self.axis[2]) > LYING

    def advance(self, told: tuple[float, float]) -> None:
        """Make one step under a command."""
        now, plant = self.now, self.plant
        command, supply, motor, floor, body = self.stages
        now.told[:] = told
        now.command[:] = told
        for hook in command:
            hook(now)
        now.duty[:] = self.control.duty(now) if self.control else now.command
        now.supply = 1.0
        for hook in supply:
            hook(now)
        for side in (0, 1):
            duty = min(max(now.duty[side], -1.0), 1.0) * now.supply
            if duty < 0.0:
                duty *= 1.0 - plant.backwards
            now.torque[side] = plant.stall[side] * (duty - now.rate[side] / plant.free[side])
            now.dry[side] = plant.dry[side]
        for hook in motor:
            hook(now)
        self._floor(floor)
        now.force[:] = (0.0, 0.0, 0.0)
        for hook in body:
            hook(now)
        self._push()
        self._contacts()
        self.world.advance()
        now.t += now.step
        self._see()
        for side in (0, 1):
            now.angle[side] += now.rate[side] * now.step

    def _floor(self, hooks: list[Hook]) -> None:
        now, plant = self.now, self.plant
        for side in (0, 1):
            half = plant.axle * (0.5 - side)
            now.spots[side] = (now.x - now.s * half, now.y + now.c * half)
            now.dry[side] += plant.rolling * self.load * plant.radius[side]
            now.load[side] = self.load
        if not hooks:
            return
        for values in (now.grip, now.grip_across, now.yielding, now.yielding_across):
            values[:] = (1.0, 1.0)
        now.film[:] = (0.0, 0.0)
        now.ahead[:] = (0.0, 0.0)
        now.drift[:] = ((0.0, 0.0), (0.0, 0.0))
        now.slope = (0.0, 0.0)
        for hook in hooks:
            hook(now)
        gx, gy = GRAVITY * math.sin(now.slope[0]), GRAVITY * math.sin(now.slope[1])
        self.world.ode.setGravity(gx, gy, -math.sqrt(max(GRAVITY**2 - gx * gx - gy * gy, 1.0)))

    def _push(self) -> None:
        now, a = self.now, self.axis
        for side in (0, 1):
            hinge = self.hinges[side]
            torque = now.torque[side] - self.bristles[side].torque(hinge.getAngleRate(), now.dry[side])
            if self.rotors:
                moment = Vec3(a[0] * torque, a[1] * torque, a[2] * torque)
                self.rotors[side].addTorque(moment)
                self.chassis.addTorque(-moment)
            else:
                hinge.addTorque(torque)
        fx, fy, turn = now.force
        if fx or fy:
            self.chassis.addForceAtPos(Vec3(fx, fy, 0.0), Vec3(now.x, now.y, self.middle))
        if turn:
            self.chassis.addTorque(Vec3(0.0, 0.0, turn))

    def _contacts(self) -> None:
        now, plant = self.now, self.plant
        ax, ay, az = self.axis
        forward = Vec3(now.c, now.s, 0.0)
        self.world.clear()
        flat = math.sqrt(1.0 - az * az)
        for side in (0, 1):
            tyre, wheel = self.setup.tyres[side], self.wheels[side]
            r = plant.radius[side]
            if tyre.hub != (0.0, 0.0):
                centre = wheel.getRelPointPos(tyre.hub[0], 0.0, tyre.hub[1])
            else:
                centre = wheel.getPosition()
            if tyre.shape is not None:
                down = wheel.vectorFromWorld(0.0, 0.0, -1.0)
                r += tyre.shape(math.atan2(down[2], down[0]))
            moving = 0.02 + abs(now.rate[side]) * r
            along = (moving * now.yielding[side] / plant.creep[0] + now.film[side]) / self.load
            across = (moving * now.yielding_across[side] / plant.creep[1] + now.film[side]) / self.load
            mu, ahead, lean = plant.friction * now.grip[side], now.ahead[side], r * az / flat
            pads = self.pads[side]
            n = len(pads)
            x, y, z = centre
            for pad, track in zip(pads, tyre.tracks):
                depth = r * flat - z - az * track
                if depth <= 0.0:
                    continue
                at_x = x + ax * (track + lean) + now.c * ahead
                at_y = y + ay * (track + lean) + now.s * ahead
                pad.surface(mu, mu * now.grip_across[side], along * n, across * n, now.drift[side])
                pad.touch(wheel, at_x, at_y, depth, forward)
        for foot in self.feet:
            foot(self, forward)
