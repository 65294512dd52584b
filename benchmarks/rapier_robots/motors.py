"""What lies between commands and wheels: a speed controller on counted encoders, and gears with play."""

from __future__ import annotations

import math

from benchmarks.rapier_robots.plant import Control

SUBSTEPS = 8
MESH = 400.0  # rad/s: natural frequency of a rotor on its gear's mesh
DAMPING = 0.7


class Speed:
    """PI control of both wheels' rates, from the counts of encoders on the motor shafts."""

    def __init__(self, control: Control, step: float) -> None:
        self.control = control
        self.every = max(round(control.period / step), 1)
        self.period = self.every * step
        self.count = 0
        self.seen = [0, 0]
        self.rate = [0.0, 0.0]
        self.sum = [0.0, 0.0]
        self.duty = [0.0, 0.0]

    def duties(self, left: float, right: float, angles: list[float]) -> list[float]:
        """Return the duties that hold until the next turn of the loop."""
        if self.count % self.every == 0:
            for k, command in enumerate((left, right)):
                self.duty[k] = self._turn(k, command, angles[k])
        self.count += 1
        return self.duty

    def _turn(self, k: int, command: float, angle: float) -> float:
        con = self.control
        unit = 2.0 * math.pi / con.ticks
        count = math.floor(angle / unit)
        raw = (count - self.seen[k]) * unit / self.period / con.full
        self.seen[k] = count
        self.rate[k] += (raw - self.rate[k]) * self.period / (self.period + con.smooth)
        error = command - self.rate[k]
        if abs(command) < 1e-6:  # firmware lets go of its sum at rest
            self.sum[k] = 0.0
            return con.kp * error
        self.sum[k] = min(max(self.sum[k] + con.ki * error * self.period, -con.windup), con.windup)
        return con.ahead * command + con.kp * error + self.sum[k]


class Gear:
    """A rotor that turns freely within the play of its gear, and pushes the wheel through a stiff mesh.

    play [rad] and inertia [kg m2] at the wheel.
    """

    def __init__(self, play: float, inertia: float, stall: float) -> None:
        self.half, self.inertia = play / 2.0, inertia
        self.stiff = inertia * MESH**2
        self.damp = 2.0 * DAMPING * inertia * MESH
        self.angle = self.rate = 0.0
        self.drag = 0.004 * stall

    def turn(self, torque: float, wheel: float, rate: float, dt: float) -> float:
        """Turn the rotor for `dt` [s] under the motor's torque; return the mean torque on the wheel [Nm]."""
        h, total = dt / SUBSTEPS, 0.0
        for n in range(SUBSTEPS):
            twist = self.angle - (wheel + rate * h * (n + 0.5))
            over = twist - self.half if twist > self.half else min(twist + self.half, 0.0)
            mesh = 0.0
            if over:
                mesh = self.stiff * over + self.damp * (self.rate - rate)
                mesh = max(mesh, 0.0) if over > 0 else min(mesh, 0.0)
            free = self.rate + (torque - mesh) * h / self.inertia
            brake = self.drag * h / self.inertia
            self.rate = math.copysign(max(abs(free) - brake, 0.0), free)
            self.angle += self.rate * h
            total += mesh
        return total / SUBSTEPS
