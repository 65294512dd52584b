"""Motors, gears, dry friction and the speed controller; one `Train` for each wheel."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from benchmarks.physx_robots.robots import Robot

if TYPE_CHECKING:
    from benchmarks.physx_robots.simulate import State

GIVE = 0.01  # rad at the wheel that dry friction yields elastically before it breaks away
STRIBECK = 0.6  # rad/s over which friction at rest falls to that in motion
MESH_SUBSTEPS = 4
MESH_DAMPING = 0.3  # of critical, of rotor and mesh


class Train:
    """Motor, gear and friction of one wheel."""

    def __init__(self, robot: Robot, side: int, step: float) -> None:
        self.motor, self.side, self.step = robot.motors[side], side, step
        self.rolls = (
            robot.loads[side] * robot.wheels[side].radius
        )  # N m of rolling resistance for a coefficient of 1
        self.bend = 0.0
        self.own = self.motor.mesh > 0.0  # the rotor moves by itself
        self.turned = 0.0
        self.rotor_rate = 0.0
        self.rotor_angle = 0.0
        self.wheel_bend = 0.0
        self.damping = 2.0 * MESH_DAMPING * math.sqrt(self.motor.mesh * self.motor.rotor)

    @property
    def angle(self) -> float:
        """What an encoder on the motor's shaft counts [rad at the wheel]."""
        return self.rotor_angle if self.own else self.turned

    def _electric(self, state: State, rate: float) -> float:
        """Return the motor's torque [N m] at a rate [rad/s]; keep its current."""
        motor, side = self.motor, self.side
        duty = state.duty[side] * state.supply
        stall, free = motor.stall * state.stall[side], motor.free * state.free[side]
        if duty < 0:
            stall *= motor.reverse_stall
            free *= motor.reverse_free
        torque = stall * (duty - rate / free)
        if motor.brake != 1.0 and torque * rate < 0:
            torque *= motor.brake
        state.current[side] = torque / motor.stall
        return torque

    def _dry(self, state: State, rate: float) -> float:
        """Return the limit of the drive's dry friction [N m]."""
        motor = self.motor
        limit = motor.coulomb + state.dry[self.side]
        if motor.breakaway != 1.0:
            limit *= 1.0 + (motor.breakaway - 1.0) * math.exp(-((rate / STRIBECK) ** 2))
        return limit * motor.reverse_coulomb if rate < 0 else limit

    def torque(self, state: State) -> float:
        """Return the torque on the wheel [N m] for the next step."""
        side = self.side
        rate = state.rate[side]
        rolling = state.rolling[side] * self.rolls
        if self.own:
            return self._meshed(state, rate, rolling)
        self.turned += rate * self.step
        limit = self._dry(state, rate) + rolling
        bend = self.bend + rate * self.step
        self.bend = bend = max(-GIVE, min(GIVE, bend))
        viscous = (self.motor.viscous + state.viscous[side]) * rate
        return self._electric(state, rate) - limit * bend / GIVE - viscous

    def _meshed(self, state: State, rate: float, rolling: float) -> float:
        """Return the same with a rotor that turns freely within the gear's play."""
        motor, step = self.motor, self.step / MESH_SUBSTEPS
        half, total = 0.5 * motor.play, 0.0
        for _ in range(MESH_SUBSTEPS):
            self.turned += rate * step
            apart = self.rotor_angle - self.turned
            over = apart - half if apart > half else apart + half if apart < -half else 0.0
            mesh = 0.0
            if over:
                mesh = motor.mesh * over + self.damping * (self.rotor_rate - rate)
                mesh = max(mesh, 0.0) if over > 0 else min(mesh, 0.0)
            bend = self.bend + self.rotor_rate * step
            self.bend = bend = max(-GIVE, min(GIVE, bend))
            dry = self._dry(state, self.rotor_rate) * bend / GIVE
            viscous = (motor.viscous + state.viscous[self.side]) * self.rotor_rate
            gain = self._electric(state, self.rotor_rate) - dry - viscous - mesh
            self.rotor_rate += step * gain / motor.rotor
            self.rotor_angle += step * self.rotor_rate
            total += mesh
        wheel_bend = self.wheel_bend + rate * self.step
        self.wheel_bend = wheel_bend = max(-GIVE, min(GIVE, wheel_bend))
        return total / MESH_SUBSTEPS - rolling * wheel_bend / GIVE


class SpeedLoop:
    """PI control of both wheels' speeds on counted ticks."""

    def __init__(self, robot: Robot) -> None:
        assert robot.controller is not None
        self.robot, self.pi = robot, robot.controller
        self.count = [0.0, 0.0]
        self.seen = [0.0, 0.0]
        self.sum = [0.0, 0.0]

    def update(self, state: State, told: tuple[float, float], angle: tuple[float, float]) -> None:
        """Set the duties so that the wheels reach `told` times the full rate."""
        pi, turn = self.pi, 2.0 * math.pi
        for side in (0, 1):
            count = math.floor(angle[side] / turn * pi.ticks) * turn / pi.ticks
            rate = (count - self.count[side]) / pi.period
            self.count[side] = count
            self.seen[side] += 0.5 * (rate - self.seen[side])
            wanted = max(-1.0, min(1.0, told[side])) * self.robot.full_rate
            error = wanted - self.seen[side]
            duty = wanted / self.robot.motors[side].free + pi.kp * error + pi.ki * self.sum[side]
            if wanted == 0.0 and abs(self.seen[side]) < 0.02 * self.robot.full_rate:
                self.sum[side] *= 0.8  # at rest the controller lets go
            elif abs(duty) < 1.0 or duty * error < 0:
                self.sum[side] += error * pi.period
            state.duty[side] = max(-1.0, min(1.0, duty))
