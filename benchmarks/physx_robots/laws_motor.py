"""Laws of motors: directions, lags and faults."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from benchmarks.physx_robots.laws import DUTY, Law, Process, log_uniform, register, sign, which
from benchmarks.physx_robots.robots import Motor, Rng, Robot, change_motors
from benchmarks.physx_robots.simulate import Drive, State

Sides = tuple[float, float]


@register
@dataclass(frozen=True)
class BrushTiming(Law):
    """Brushes set ahead for one direction: backwards the motor is weaker and slower (or stronger, mounted
    mirrored).
    """

    label, law, grows, span, needs = (
        "motor_reverse_asymmetry",
        "brush_timing",
        {"lack": 1},
        (0.003, 0.6),
        DUTY,
    )
    cause = "advanced brush timing of DC motors makes speed and torque unlike by direction (Mabuchi catalogue notes)"
    sides: Sides
    lack: float
    sense: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the share and its sign."""
        return cls(which(rng), log_uniform(rng, 0.04, 0.2), sign(rng))

    def build(self, robot: Robot) -> Robot:
        """Return the robot with unlike directions."""
        share = 1.0 - self.sense * self.lack

        def change(m: Motor) -> Motor:
            return replace(m, reverse_free=m.reverse_free * share, reverse_stall=m.reverse_stall * share)

        return change_motors(robot, change, self.sides)


@register
@dataclass(frozen=True)
class GearThrust(Law):
    """Backwards a gear's thrust presses on a dry washer: more dry friction [share of stall torque]."""

    label, law, grows, span, needs = (
        "motor_reverse_asymmetry",
        "gear_thrust",
        {"extra": 1},
        (0.002, 0.5),
        DUTY,
    )
    cause = "axial thrust of worm and helical gears changes side with direction (Shigley, Mech. Eng. Design, ch. 13)"
    sides: Sides
    extra: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the friction."""
        return cls(which(rng), log_uniform(rng, 0.03, 0.15))

    def build(self, robot: Robot) -> Robot:
        """Return the robot with more friction backwards."""

        def change(m: Motor) -> Motor:
            return replace(m, reverse_coulomb=m.reverse_coulomb + self.extra * m.stall / m.coulomb)

        return change_motors(robot, change, self.sides)


@register
@dataclass(frozen=True)
class BadHalfBridge(Law):
    """Backwards the current goes through a transistor of higher resistance and drop."""

    label, law, grows, span, needs = (
        "motor_reverse_asymmetry",
        "bad_half_bridge",
        {"drop": 1},
        (0.003, 0.5),
        DUTY,
    )
    cause = "one damaged half-bridge (higher on-resistance) loses voltage in one direction only"
    sides: Sides
    drop: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the loss."""
        return cls(which(rng, 0.25), log_uniform(rng, 0.05, 0.2))

    def build(self, robot: Robot) -> Robot:
        """Return the robot whose duty backwards is worth less (drop) at a flatter torque line (half of it)."""

        def change(m: Motor) -> Motor:
            stall = m.reverse_stall * (1 - self.drop) / (1 + 0.5 * self.drop)
            return replace(m, reverse_free=m.reverse_free * (1 - self.drop), reverse_stall=stall)

        return change_motors(robot, change, self.sides)


@register
@dataclass(frozen=True)
class Coasting(Law):
    """The driver brakes badly: against the motion a motor has 1 - `lack` of its torque, so that it slows late."""

    label, law, grows, span, needs = "motor_asymmetric_lag", "coasting_driver", {"lack": 1}, (0.01, 1.0), DUTY
    cause = "braking current only through diodes or for part of the period (fast and mixed decay; Mohan et al., ch. 7)"
    sides: Sides
    lack: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the missing share of braking torque."""
        return cls(which(rng, 0.5), log_uniform(rng, 0.2, 0.9))

    def build(self, robot: Robot) -> Robot:
        """Return the robot with drivers that brake less."""
        return change_motors(robot, lambda m: replace(m, brake=1.0 - self.lack), self.sides)


class Weak(Process):
    """A motor that has less voltage and torque within some moments."""

    def __init__(self, sides: Sides, loss: float, moments: list[tuple[float, float]]) -> None:
        self.sides, self.loss, self.moments = sides, loss, moments

    def tick(self, state: State) -> None:
        """Weaken the motor while a moment lasts."""
        if any(a <= state.t < b for a, b in self.moments):
            for side in (0, 1):
                if self.sides[side]:
                    state.stall[side] *= 1.0 - self.loss
                    state.free[side] *= 1.0 - 0.8 * self.loss


@dataclass(frozen=True)
class Fault(Law):
    """A motor loses `loss` of its strength within moments that each run draws."""

    local = True
    sides: Sides
    loss: float

    def moments(self, rng: Rng) -> list[tuple[float, float]]:
        """Return the moments [s] of a run."""
        raise NotImplementedError

    def process(self, rng: Rng) -> Process:
        """Return the weakness."""
        return Weak(self.sides, self.loss, self.moments(rng))

    def touched(self, drive: Drive, rng: Rng) -> np.ndarray:
        """Return the moments as a mask."""
        mask = np.zeros(len(drive.time), dtype=bool)
        for a, b in self.moments(rng):
            mask |= (drive.time >= a) & (drive.time < b + 0.3)
        return mask


@register
@dataclass(frozen=True)
class ThermalCutback(Fault):
    """For some seconds a hot driver gives less."""

    label, law, grows, span, needs = "motor_fault", "thermal_cutback", {"loss": 1}, (0.005, 0.95), DUTY
    cause = (
        "over-temperature protection of bridge drivers until they have cooled (e.g. ST VNH5019 data sheet)"
    )

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw side and loss."""
        return cls(which(rng, 0.0), log_uniform(rng, 0.12, 0.6))

    def moments(self, rng: Rng) -> list[tuple[float, float]]:
        """Return one or two spells of 5 to 12 s."""
        starts = [rng.uniform(8, 22)] + ([rng.uniform(34, 44)] if rng.random() < 0.6 else [])
        return [(float(a), float(a + rng.uniform(5, 12))) for a in starts]


@register
@dataclass(frozen=True)
class LoosePlug(Fault):
    """Now and then a plug loses contact for a moment."""

    label, law, grows, span, needs = "motor_fault", "loose_plug", {"loss": 1}, (0.01, 1.0), DUTY
    cause = "intermittent contact of a vibrating connector (fretting, Slade, Electrical Contacts)"

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw side and loss."""
        return cls(which(rng, 0.0), log_uniform(rng, 0.3, 1.0))

    def moments(self, rng: Rng) -> list[tuple[float, float]]:
        """Return dropouts of 0.2 to 1 s, about one in 5 s."""
        starts = 3.0 + np.cumsum(rng.exponential(5.0, 12) + 1.2)
        return [(float(a), float(a + rng.uniform(0.2, 1.0))) for a in starts if a < 60]


@register
@dataclass(frozen=True)
class BrokenCoil(Fault):
    """From some time on a motor is weaker: a winding's lead broke."""

    label, law, grows, span, needs = "motor_fault", "broken_coil", {"loss": 1}, (0.005, 0.9), DUTY
    cause = "one open armature coil takes its share of the torque for good (motor diagnosis handbooks)"

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw side and loss."""
        return cls(which(rng, 0.0), log_uniform(rng, 0.12, 0.5))

    def moments(self, rng: Rng) -> list[tuple[float, float]]:
        """Return one spell from 20 to 35 s to the end."""
        return [(float(rng.uniform(20, 35)), 1e9)]
