"""Laws of the supply and of warmth: what changes with load and with time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

from benchmarks.physx_robots.laws import DUTY, Law, Process, log_uniform, register, which
from benchmarks.physx_robots.robots import Rng, Robot
from benchmarks.physx_robots.simulate import State

Sides = tuple[float, float]


class Cell(Process):
    """A battery: series resistance, polarisation, and charge that runs out. Currents in stall currents of one
    motor.
    """

    def __init__(self, ohmic: float, slow: float, slow_s: float, fall: float) -> None:
        self.ohmic, self.slow, self.slow_s, self.fall = ohmic, slow, slow_s, fall
        self.polarised = self.drawn = self.smooth = 0.0

    def tick(self, state: State) -> None:
        """Set the supply for the motors' present current."""
        current = sum(max(c * d, 0.0) for c, d in zip(state.current, state.duty))
        self.smooth += 0.2 * (current - self.smooth)  # capacitors of some 50 ms
        if self.slow:
            self.polarised += 0.01 / self.slow_s * (self.slow * current - self.polarised)
        self.drawn += 0.01 * (0.05 + current)
        charge = self.drawn / 8.0
        empty = self.fall * (0.7 * charge + 0.3 * charge**3)
        state.supply *= max(1.0 - self.ohmic * self.smooth - self.polarised - empty, 0.3)


@register
@dataclass(frozen=True)
class InnerResistance(Law):
    """The supply falls with the current: `ohmic` of it at one motor's stall current."""

    label, law, grows, span, needs = "battery_sag", "inner_resistance", {"ohmic": 1}, (0.02, 2.5), DUTY
    cause = "series resistance of old cells and thin leads (Linden's Handbook of Batteries, ch. 3)"
    ohmic: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the resistance."""
        return cls(log_uniform(rng, 0.15, 0.8))

    def process(self, rng: Rng) -> Process:
        """Return the battery."""
        return Cell(self.ohmic, 0.0, 1.0, 0.0)


@register
@dataclass(frozen=True)
class RunningDown(Law):
    """An almost empty battery falls with the charge drawn, ever faster."""

    label, law, grows, span, needs = (
        "battery_sag",
        "running_down",
        {"fall": 1, "ohmic": 1},
        (0.004, 0.6),
        DUTY,
    )
    cause = "end of the discharge curve of lithium and NiMH cells (Linden's Handbook of Batteries, discharge curves)"
    fall: float
    ohmic: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw fall over eight stall current seconds, and resistance."""
        fall = log_uniform(rng, 0.1, 0.4)
        return cls(fall, fall * float(rng.uniform(0.2, 1.0)))

    def process(self, rng: Rng) -> Process:
        """Return the battery."""
        return Cell(self.ohmic, 0.0, 1.0, self.fall)


@register
@dataclass(frozen=True)
class Polarised(Law):
    """The supply falls slowly under load and recovers at rest (Thevenin's RC)."""

    label, law, grows, span, needs = "battery_sag", "polarisation", {"slow": 1, "ohmic": 1}, (0.02, 2.5), DUTY
    cause = "diffusion overpotential, one RC branch (Plett, Battery Management Systems vol. 1, ch. 2)"
    slow: float
    slow_s: float
    ohmic: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw both resistances and the time constant."""
        slow = log_uniform(rng, 0.2, 0.8)
        return cls(slow, log_uniform(rng, 3.0, 15.0), slow * float(rng.uniform(0.2, 0.8)))

    def process(self, rng: Rng) -> Process:
        """Return the battery."""
        return Cell(self.ohmic, self.slow, self.slow_s, 0.0)


class Heat(Process):
    """Copper heats by the current's square and cools; resistance rises and the magnets weaken."""

    def __init__(self, law: HotCopper) -> None:
        self.law, self.hot = law, [0.0, 0.0]

    def tick(self, state: State) -> None:
        """Advance the temperatures (1 = fully warm at the drive's usual current) and change the motors."""
        for side in (0, 1):
            heat = (abs(state.duty[side]) + 3.0 * state.current[side] ** 2) / 0.55
            self.hot[side] += 0.01 / self.law.warm_s * (heat - self.hot[side])
            if self.law.sides[side]:
                magnets = 1.0 - self.law.magnets * self.hot[side]
                state.free[side] /= magnets
                state.stall[side] *= magnets / (1.0 + self.law.copper * self.hot[side])


@register
@dataclass(frozen=True)
class HotCopper(Law):
    """Winding resistance rises by `copper`, the magnets' flux falls by `magnets`, when warm (shares)."""

    label, law, grows, span, needs = (
        "motor_warmup",
        "hot_copper",
        {"magnets": 1, "copper": 1},
        (0.002, 0.35),
        DUTY,
    )
    cause = "copper +0.39 %/K, ferrite -0.2 %/K (Maxon's motor formulas; magnet makers' tables)"
    sides: Sides
    magnets: float
    copper: float
    warm_s: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the shares, 1 to 2.2 of copper to ferrite, and the time constant."""
        magnets = log_uniform(rng, 0.03, 0.12)
        return cls(
            which(rng, 0.6), magnets, magnets * float(rng.uniform(1.2, 2.2)), log_uniform(rng, 8.0, 30.0)
        )

    def process(self, rng: Rng) -> Process:
        """Return the heat."""
        return Heat(self)


class Grease(Process):
    """Cold grease drags by the rate, and less as it is worked."""

    def __init__(self, law: ColdGrease) -> None:
        self.law, self.worked = law, [0.0, 0.0]

    def tick(self, state: State) -> None:
        """Advance the work and add the drag."""
        for side in (0, 1):
            self.worked[side] += 0.01 * abs(state.rate[side]) / state.robot.full_rate
            if self.law.sides[side]:
                motor = state.robot.motors[side]
                left = self.law.cold * math.exp(-self.worked[side] / self.law.warm_s)
                state.viscous[side] += left * motor.stall / motor.free
                state.dry[side] += 0.15 * left * motor.stall


@register
@dataclass(frozen=True)
class ColdGrease(Law):
    """Drag of cold grease, `cold` of the motor's own torque over rate, that fades after `warm_s` seconds at
    full speed.
    """

    label, law, grows, span, needs = "motor_warmup", "cold_grease", {"cold": 1}, (0.006, 1.2), DUTY
    cause = "gear grease thins as it is sheared and warmed (Klueber and Maxon gear notes on cold starts)"
    sides: Sides
    cold: float
    warm_s: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw drag and time."""
        return cls(which(rng, 0.6), log_uniform(rng, 0.12, 0.5), log_uniform(rng, 4.0, 12.0))

    def process(self, rng: Rng) -> Process:
        """Return the grease."""
        return Grease(self)
