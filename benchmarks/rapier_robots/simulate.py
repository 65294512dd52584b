"""One drive: commands pass through hooks, controller and motors to the wheels of the engine's robot."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.rapier_robots.engine import ROTOR, STEP, Creep, World
from benchmarks.rapier_robots.motors import Gear, Speed
from benchmarks.rapier_robots.setup import Array, Setup, State

EVERY = 0.01  # s between samples of the truth
LIMIT = 40.0  # m: a robot that is further away has run off
Source = Callable[[float, float, float, float], tuple[float, float]]


class RanOff(Exception):
    """The robot tipped over or ran away."""


@dataclass(frozen=True)
class Drive:
    """What really happened, every 10 ms: axle's middle [m, rad], wheel angles [rad]; and the commands as told."""

    time: Array
    x: Array
    y: Array
    yaw: Array
    left: Array
    right: Array
    touched: Array
    commands: Array
    tick: float

    @property
    def seconds(self) -> float:
        """Length [s]."""
        return len(self.commands) * self.tick


def replay(commands: Array, tick: float) -> Source:
    """Return a source that tells recorded commands again."""

    def source(t: float, x: float, y: float, yaw: float) -> tuple[float, float]:
        row = commands[min(int(t / tick + 0.5), len(commands) - 1)]
        return float(row[0]), float(row[1])

    return source


class Simulation:
    """A robot in the engine with its hooks; `run` drives it."""

    def __init__(self, setup: Setup, run: int, start: tuple[float, float, float], step: float = STEP) -> None:
        self.setup, self.plant, self.dt = setup, setup.plant, step
        self.world = World(setup.plant, *start, step=step)
        self.state = State()
        self.state.x, self.state.y, self.state.yaw = start
        self.commands = [make(run) for make in setup.commands]
        self.supplies = [make(run) for make in setup.supplies]
        self.torques = [make(run) for make in setup.torques]
        self.floors = [make(run) for make in setup.floors]
        self.rims = [make(run) for make in setup.rims]
        self.creeps = [make(run) for make in setup.creeps]
        self.creep = Creep(self.world) if self.creeps else None
        self.control = Speed(setup.control, step) if setup.control else None
        p = self.plant
        self.gears = [
            Gear(p.play[k], ROTOR * p.armature[k], p.stall[k]) if p.play[k] else None for k in (0, 1)
        ]
        self.base = [p.dry[k] + p.rolling[k] * p.wheel_load * p.radius[k] for k in (0, 1)]
        self.set_hold, self.set_grip = list(self.base), [1.0, 1.0]
        self.side = self.set_ball = 0.0
        self.axis = (0.0, 1.0, 0.0)

    def _look(self) -> None:
        """Read the engine's state."""
        st, body = self.state, self.world.chassis
        q, at, spin, v = body.rotation, body.translation, body.angvel, body.linvel
        i, j, k, w = q.i, q.j, q.k, q.w
        ax, ay, az = 2 * (i * j - k * w), 1 - 2 * (i * i + k * k), 2 * (j * k + i * w)
        self.axis = (ax, ay, az)
        yaw = math.atan2(-ax, ay)
        st.yaw += math.remainder(yaw - st.yaw, 2.0 * math.pi)
        st.c, st.s = math.cos(yaw), math.sin(yaw)
        st.x, st.y, st.turn = at.x, at.y, spin.z
        st.speed = v.x * st.c + v.y * st.s + st.turn * self.plant.com[1]
        own = spin.x * ax + spin.y * ay + spin.z * az
        for n, wheel in enumerate(self.world.wheels):
            u = wheel.angvel
            rate = u.x * ax + u.y * ay + u.z * az - own
            st.angle[n] += 0.5 * (rate + st.rate[n]) * self.dt
            st.rate[n] = rate

    def _motors(self) -> None:
        """Turn duties into torques between body and wheels."""
        st, p, dt, total = self.state, self.plant, self.dt, 0.0
        volts = 1.0
        for supply in self.supplies:
            volts = supply(st, volts)
        st.volts = volts
        ax, ay, az = self.axis
        for k in (0, 1):
            gear = self.gears[k]
            rate = gear.rate if gear else st.rate[k]
            duty = st.duty[k]
            load = duty * volts - rate / p.free[k]
            torque = p.stall[k] * load - p.viscous[k] * rate
            for hook in self.torques:
                torque = hook(st, k, duty, torque)
            st.load[k] = load
            if gear:
                torque = gear.turn(torque, st.angle[k], st.rate[k], dt)
            total += torque
            wheel = self.world.wheels[k]
            wheel.reset_torques()
            wheel.add_torque((torque * ax, torque * ay, torque * az))
        body = self.world.chassis
        body.reset_torques()
        body.add_torque((-total * ax, -total * ay, st.tz - total * az))

    def _ground(self) -> None:
        """Let hooks of floor, pushes and loads act."""
        st = self.state
        st.fx = st.fy = st.tz = st.ball = 0.0
        st.touched = False
        st.hold[0] = st.hold[1] = 0.0
        st.grip[0] = st.grip[1] = 1.0
        for floor in self.floors:
            floor(st)
        for k in (0, 1):
            hold = self.base[k] + st.hold[k]
            if abs(hold - self.set_hold[k]) > 0.01 * self.base[k]:
                self.world.set_friction(k, hold)
                self.set_hold[k] = hold
            if abs(st.grip[k] - self.set_grip[k]) > 0.01:
                self.world.set_grip(k, self.plant.grip[k] * st.grip[k])
                self.set_grip[k] = st.grip[k]
        if abs(st.ball - self.set_ball) > 0.002:
            self.world.set_ball(st.ball)
            self.set_ball = st.ball
        self.world.chassis.reset_forces()
        self.world.chassis.add_force((st.fx, st.fy, 0.0))

    def _slip(self) -> None:
        """Move the tyres' contacts sideways as the axle's force asks."""
        hook, st = self.creep, self.state
        if hook is None:
            return
        self.side = -(self.world.side_force(0) + self.world.side_force(1))
        speed = 0.0
        for creep in self.creeps:
            speed += creep(st, self.side)
        st.creep = speed
        hook.velocity = (-st.s * speed, st.c * speed, 0.0)

    def advance(self, left: float, right: float) -> None:
        """Go on by one step with commands."""
        st = self.state
        self._look()
        for command in self.commands:
            left, right = command(st, left, right)
        if self.control:
            angles = [g.angle if g else st.angle[k] for k, g in enumerate(self.gears)]
            left, right = self.control.duties(left, right, angles)
        st.duty[0] = min(max(left, -1.0), 1.0)
        st.duty[1] = min(max(right, -1.0), 1.0)
        if self.floors:
            self._ground()
        self._motors()
        if self.creep:
            self._slip()
        for rim in self.rims:
            for k in (0, 1):
                self.world.set_rim(k, *rim(st.angle[k], k))
        self.world.step()
        st.t += self.dt

    def run(self, source: Source, seconds: float, tick: float) -> Drive:
        """Drive for some seconds, with commands from `source` every `tick` [s]."""
        per_tick, per_row = round(tick / self.dt), round(EVERY / self.dt)
        rows: list[tuple[Any, ...]] = []
        told: list[tuple[float, float]] = []
        st, touched = self.state, False
        u = (0.0, 0.0)
        for n in range(round(seconds / tick) * per_tick):
            if n % per_tick == 0:
                u = source(n * self.dt, st.x, st.y, st.yaw)
                told.append(u)
            if n % per_row == 0:
                self._sample(rows, touched)
                touched = False
            self.advance(*u)
            touched = touched or st.touched
        table = np.array(rows)
        time = np.arange(len(table)) * EVERY
        x, y, yaw, left, right, hit = table.T
        return Drive(time, x, y, yaw, left, right, hit, np.array(told), tick)

    def _sample(self, rows: list[tuple[Any, ...]], touched: bool) -> None:
        st = self.state
        body = self.world.chassis
        at = body.translation
        if not (abs(at.x) < LIMIT and abs(at.y) < LIMIT and abs(self.axis[2]) < 0.5):
            raise RanOff(f"at {st.t:.1f} s")
        q = body.rotation
        yaw = math.atan2(-2 * (q.i * q.j - q.k * q.w), 1 - 2 * (q.i * q.i + q.k * q.k))
        yaw = st.yaw + math.remainder(yaw - st.yaw, 2.0 * math.pi)
        angles = [g.angle if g else st.angle[k] for k, g in enumerate(self.gears)]
        rows.append((at.x, at.y, yaw, *angles, touched))


def simulate(
    setup: Setup, source: Source, seconds: float, run: int, start: tuple[float, float, float]
) -> Drive:
    """Return one drive of a robot from rest at `start` (x, y [m], yaw [rad])."""
    return Simulation(setup, run, start).run(source, seconds, setup.robot.tick)
