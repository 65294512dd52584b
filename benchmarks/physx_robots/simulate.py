"""The loop: commands through electronics, motors, gears and tyres into the engine, step by step."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.physx_robots.drivetrain import SpeedLoop, Train
from benchmarks.physx_robots.engine import STEP, Body
from benchmarks.physx_robots.laws import Process
from benchmarks.physx_robots.robots import Robot
from benchmarks.physx_robots.tyres import BrushPair

TICK = 5  # steps from one row of a drive to the next, and between changes of slow quantities
Source = Callable[[float, tuple[float, float, float]], tuple[float, float]]
"""Commands (left, right) in -1..1 at a time [s] and a pose (x, y [m], yaw [rad])."""


class State:
    """What processes see and change. Pairs are (left, right).

    t [s]; x, y [m] and yaw [rad] of the axle's middle; vx, vy [m/s] of the world; turn [rad/s]; rate [rad/s]
    and angle [rad] of the wheels; duty -1..1; current: torque over stall torque, of each motor. Nominal at each
    tick, and then changed: supply (share), stall and free (shares), dry [N m], viscous [N m s], rolling (over
    load), grip (share). Added each step: fx, fy [N], moment [N m] about the axle's middle.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.t = self.x = self.y = self.yaw = self.vx = self.vy = self.turn = 0.0
        self.rate, self.angle, self.duty, self.current = [0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]
        self.fx = self.fy = self.moment = 0.0
        self.nominal()

    def nominal(self) -> None:
        """Set what ticks change to nominal."""
        self.supply = 1.0
        self.stall, self.free, self.grip = [1.0, 1.0], [1.0, 1.0], [1.0, 1.0]
        self.dry, self.viscous = [0.0, 0.0], [0.0, 0.0]
        self.rolling = [self.robot.rolling, self.robot.rolling]

    def push(self, fx: float, fy: float, rx: float = 0.0, ry: float = 0.0) -> None:
        """Add a force [N] of the world that acts (rx, ry) [m] of the world from the axle's middle."""
        self.fx += fx
        self.fy += fy
        self.moment += rx * fy - ry * fx

    @property
    def forward(self) -> float:
        """Speed ahead [m/s]."""
        return self.vx * math.cos(self.yaw) + self.vy * math.sin(self.yaw)


@dataclass(frozen=True)
class Drive:
    """One run: time [s] every 10 ms, pose of the axle's middle, encoder angles [rad], the commands as told, and how
    far the body leaned at most [rad]."""

    time: np.ndarray
    x: np.ndarray
    y: np.ndarray
    yaw: np.ndarray
    angle: np.ndarray
    command_time: np.ndarray
    command: np.ndarray
    leaned: float = 0.0


def replay(time: np.ndarray, command: np.ndarray) -> Source:
    """Return a source that tells recorded commands again."""
    rows = iter(command.tolist())
    return lambda t, pose: tuple(next(rows))  # type: ignore[return-value]


def _overrides(processes: Sequence[Process], name: str) -> list[Process]:
    return [p for p in processes if getattr(type(p), name) is not getattr(Process, name)]


class Simulation:
    """A robot with the processes that act on it."""

    def __init__(self, robot: Robot, processes: Sequence[Process], step: float = STEP) -> None:
        self.robot, self.step = robot, step
        self.body = Body(robot, step)
        self.state = State(robot)
        self.command_hooks = _overrides(processes, "command")
        self.tick_hooks = _overrides(processes, "tick")
        self.force_hooks = _overrides(processes, "force")
        self.trains = [Train(robot, side, step) for side in (0, 1)]
        self.fork = ForkFriction(robot, self.body, step)
        self.brush = BrushPair(robot, step) if robot.tyre.brush else None
        self.loop = SpeedLoop(robot) if robot.controller else None
        self.grips = [1.0, 1.0]
        self.leaned = 0.0  # (half the angle) squared

    def run(self, source: Source, duration: float) -> Drive:
        """Drive for `duration` [s]."""
        robot, state, step = self.robot, self.state, self.step
        tick = round(TICK * STEP / step)
        each = round(robot.command_period / step)
        control = round(robot.controller.period / step) if robot.controller else 0
        rows: list[tuple[float, ...]] = []
        told: list[tuple[float, float, float]] = []
        left = right = 0.0
        for k in range(round(duration / step)):
            state.t = k * step
            if k % tick == 0:
                self._tick()
                rows.append(
                    (state.t, state.x, state.y, state.yaw, self.trains[0].angle, self.trains[1].angle)
                )
            if k % each == 0:
                left, right = source(state.t, (state.x, state.y, state.yaw))
                told.append((state.t, left, right))
            a, b = left, right
            for hook in self.command_hooks:
                a, b = hook.command(state, a, b)
            if robot.bend:
                a, b = (math.copysign(abs(u) ** (1.0 + robot.bend), u) for u in (a, b))
            if self.loop is None:
                state.duty[0], state.duty[1] = max(-1.0, min(1.0, a)), max(-1.0, min(1.0, b))
            elif k % control == 0:
                self.loop.update(state, (a, b), (self.trains[0].angle, self.trains[1].angle))
            self._advance()
        return _drive(rows, told, 2.0 * math.sqrt(self.leaned))

    def _tick(self) -> None:
        state = self.state
        state.nominal()
        for hook in self.tick_hooks:
            hook.tick(state)
        if self.brush is None:
            for side in (0, 1):
                if state.grip[side] != self.grips[side]:
                    self.grips[side] = state.grip[side]
                    self.body.set_grip(side, self.robot.tyre.grip * state.grip[side])

    def _advance(self) -> None:
        state, body = self.state, self.body
        torque = body.joint_torque
        torque[0] = self.trains[0].torque(state)
        torque[1] = self.trains[1].torque(state)
        self.fork.apply(torque)
        state.fx = state.fy = state.moment = 0.0
        for hook in self.force_hooks:
            hook.force(state)
        if self.brush is not None:
            self.brush.apply(state, torque)
        if self.force_hooks or self.brush is not None:
            body.push((state.fx, state.fy), state.moment, (state.x, state.y, state.yaw))
        body.step()
        self._read()

    def _read(self) -> None:
        state, articulation = self.state, self.body.articulation
        pose = articulation.root_pose
        x, y, _ = pose.p.tolist()
        w, a, b, z = pose.q.tolist()
        self.leaned = max(self.leaned, a * a + b * b)
        yaw = 2.0 * math.atan2(z, w)
        state.turn = float(articulation.root_angular_velocity[2])
        state.vx, state.vy = (x - state.x) / self.step, (y - state.y) / self.step
        state.x, state.y = x, y
        state.yaw += (yaw - state.yaw + math.pi) % (2.0 * math.pi) - math.pi
        rates = articulation.qvel.tolist()
        for side in (0, 1):
            state.rate[side] = rates[side]
            state.angle[side] += rates[side] * self.step
        self.fork.rates = rates[2:]


def _drive(rows: list[tuple[float, ...]], told: list[tuple[float, float, float]], leaned: float) -> Drive:
    table, commands = np.array(rows), np.array(told)
    x, y, yaw = table[:, 1:4].T
    return Drive(table[:, 0], x, y, yaw, table[:, 4:6], commands[:, 0], commands[:, 1:], leaned)


class ForkFriction:
    """Dry friction in the two joints of a swivelling caster, as an elastic limit (Prandtl)."""

    def __init__(self, robot: Robot, body: Body, step: float) -> None:
        caster = robot.casters[0]
        self.limits = [caster.swivel, caster.axle] if body.articulation.dof > 2 else []
        self.give = [0.01, 0.02]  # rad before a joint breaks away
        self.bend = [0.0, 0.0]
        self.rates: list[float] = [0.0, 0.0]
        self.step = step

    def apply(self, torque: np.ndarray) -> None:
        """Set the torques of the fork's joints."""
        for i, limit in enumerate(self.limits):
            if limit:
                bend = self.bend[i] + self.rates[i] * self.step
                self.bend[i] = bend = max(-self.give[i], min(self.give[i], bend))
                torque[2 + i] = -limit * bend / self.give[i]
