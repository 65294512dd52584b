"""Laws of the command path: what firmware and driver electronics make of a command."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Self

from benchmarks.physx_robots.laws import DUTY, SPEED, Law, Process, log_uniform, register, sign, which
from benchmarks.physx_robots.robots import Rng, Robot, change_motors
from benchmarks.physx_robots.simulate import State

Sides = tuple[float, float]


class Mapped(Process):
    """A static map of each side's command, where the side's weight is not zero."""

    def __init__(self, law: Any) -> None:
        self.map, self.sides = law.map, law.sides

    def command(self, state: State, left: float, right: float) -> tuple[float, float]:
        """Return the mapped commands."""
        return (self.map(left) if self.sides[0] else left), (self.map(right) if self.sides[1] else right)


@dataclass(frozen=True)
class StaticMap(Law):
    """A law that is a map of the command; subclasses give `map`."""

    sides: Sides

    def map(self, u: float) -> float:
        """Return what a command acts as."""
        raise NotImplementedError

    def process(self, rng: Rng) -> Process:
        """Return the map at work."""
        return Mapped(self)


@register
@dataclass(frozen=True)
class FirmwareCut(StaticMap):
    """Commands below `width` are taken for noise and dropped; above it they act in full."""

    label, law, grows, span = "motor_deadband", "firmware_cut", {"width": 1}, (0.01, 0.5)
    cause = "joystick and motor firmware zero small set values (e.g. RoboClaw and ODrive dead-band settings)"
    width: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the width."""
        return cls(which(rng, 0.8), log_uniform(rng, 0.08, 0.3))

    def map(self, u: float) -> float:
        """Return the command or 0."""
        return u if abs(u) >= self.width else 0.0


@register
@dataclass(frozen=True)
class BridgeDrop(StaticMap):
    """The bridge's transistors keep a constant voltage for themselves."""

    label, law, grows, span = "motor_deadband", "bridge_drop", {"drop": 1}, (0.004, 0.4)
    cause = (
        "bipolar bridge, saturation voltages 1.8 to 3.2 V of the supply (ST L298 data sheet, V_CEsat total)"
    )
    needs = DUTY
    drop: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the drop as share of the supply."""
        return cls(which(rng, 0.7), log_uniform(rng, 0.05, 0.25))

    def map(self, u: float) -> float:
        """Return what is left of the duty."""
        return math.copysign(max(abs(u) - self.drop, 0.0), u)


@register
@dataclass(frozen=True)
class BrokenCurrent(StaticMap):
    """At small duties the current dies out within each PWM period, so that they act less."""

    label, law, grows, span = "motor_deadband", "broken_current", {"knee": 1}, (0.01, 0.6)
    cause = "discontinuous armature current at low duty and fast decay (Mohan et al., Power Electronics, ch. 7 and 13)"
    needs = DUTY
    knee: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the duty at which the current stays continuous."""
        return cls(which(rng, 0.7), log_uniform(rng, 0.1, 0.4))

    def map(self, u: float) -> float:
        """Return the duty times a share that falls to 0 with it."""
        return u * (1.0 - math.exp(-((u / self.knee) ** 2)))


@register
@dataclass(frozen=True)
class HardClip(StaticMap):
    """No command acts beyond a limit."""

    label, law, grows, span = "command_saturation", "hard_clip", {"cut": 1}, (0.03, 0.85)
    cause = "speed limit left in the firmware, or a charge-pump gate driver's largest duty (IR2104 application notes)"
    cut: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw how much of the range is cut off."""
        return cls(which(rng, 0.7), log_uniform(rng, 0.2, 0.6))

    def sizes(self) -> dict[str, Any]:
        """Return the limit itself."""
        return {"limit": 1.0 - self.cut, "sides": self.sides}

    def map(self, u: float) -> float:
        """Return the command within the limit."""
        return max(-(1.0 - self.cut), min(1.0 - self.cut, u))


@register
@dataclass(frozen=True)
class SoftKnee(StaticMap):
    """Above a knee commands bend over into a ceiling."""

    label, law, grows, span = "command_saturation", "soft_knee", {"cut": 1}, (0.01, 0.8)
    cause = "current-sensing driver folds the duty back as load rises (TI DRV8871 current regulation)"
    needs = DUTY
    cut: float
    width: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the ceiling and how gradual the knee is."""
        return cls(which(rng, 0.7), log_uniform(rng, 0.25, 0.6), float(rng.uniform(0.05, 0.2)))

    def map(self, u: float) -> float:
        """Return the command below a smooth ceiling."""
        over = (abs(u) - (1.0 - self.cut)) / self.width
        soft = self.width * math.log1p(math.exp(over)) if over < 30 else self.width * over
        return math.copysign(max(abs(u) - soft, 0.0), u) if u else 0.0


@register
@dataclass(frozen=True)
class ShortOfVolts(Law):
    """A speed-controlled motor's free speed is `headroom` of the set speed at command 1: large commands are out
    of reach.
    """

    label, law, grows, span = "command_saturation", "short_of_volts", {"headroom": -1}, (0.2, 1.4)
    cause = "motor wound for a higher supply: no-load speed below the set speed (torque-speed lines, e.g. Pololu 37D)"
    needs = SPEED
    headroom: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the headroom."""
        return cls(float(rng.uniform(0.5, 0.95)))

    def build(self, robot: Robot) -> Robot:
        """Return the robot with slower motors of the same stall torque."""
        return change_motors(robot, lambda m: replace(m, free=min(m.free, robot.full_rate * self.headroom)))


@register
@dataclass(frozen=True)
class Expo(StaticMap):
    """Speed over command bends like a power."""

    label, law, grows, span = "motor_gain_curve", "expo", {"bend": 1}, (0.006, 0.8)
    cause = "exponential throttle curves in hobby speed controllers and transmitters (Futaba, FrSky manuals: 'expo')"
    bend: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the power's distance from 1."""
        return cls(which(rng, 0.6), sign(rng) * log_uniform(rng, 0.1, 0.5))

    def map(self, u: float) -> float:
        """Return the bent command."""
        return math.copysign(abs(u) ** (1.0 + self.bend if self.bend > 0 else 1.0 / (1.0 - self.bend)), u)


@register
@dataclass(frozen=True)
class Table(StaticMap):
    """A calibration table in the firmware with a few wrong entries."""

    label, law, grows, span = "motor_gain_curve", "wrong_table", {"size": 1}, (0.005, 0.6)
    cause = "PWM lookup tables measured once on another motor (interpolated between a few points)"
    size: float
    shape: tuple[float, ...]

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw errors at a quarter, a half and three quarters of the range, of one trend."""
        lean = sign(rng)
        return cls(
            which(rng, 0.5),
            log_uniform(rng, 0.06, 0.3),
            tuple(float(lean * rng.uniform(0.3, 1)) for _ in range(3)),
        )

    def map(self, u: float) -> float:
        """Return the command by the table."""
        knots = [q * (1.0 + self.size * e) for q, e in zip((0.25, 0.5, 0.75), self.shape)]
        place = min(abs(u), 1.0) * 4.0
        i = min(int(place), 3)
        ends = [0.0, *knots, 1.0]
        return math.copysign(ends[i] + (place - i) * (ends[i + 1] - ends[i]), u)


@register
@dataclass(frozen=True)
class SlowDecay(StaticMap):
    """With slow switching the loaded speed rises early and then flattens: u + a u (1 - u)."""

    label, law, grows, span = "motor_gain_curve", "slow_decay_bulge", {"bulge": 1}, (0.006, 0.9)
    cause = "sign-magnitude PWM with slow decay: speed over duty is concave (Pololu and Adafruit notes on decay modes)"
    needs = DUTY
    bulge: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the bulge."""
        return cls(which(rng, 0.5), log_uniform(rng, 0.1, 0.5))

    def map(self, u: float) -> float:
        """Return the bulged duty."""
        return u * (1.0 + self.bulge * (1.0 - abs(u)))


class Ramp(Process):
    """Limits how fast commands rise in size, or fall."""

    def __init__(self, law: SoftStart) -> None:
        self.law, self.at = law, [0.0, 0.0]

    def command(self, state: State, left: float, right: float) -> tuple[float, float]:
        """Return the ramped commands."""
        told = (left, right)
        for side in (0, 1):
            if not self.law.sides[side]:
                self.at[side] = told[side]
                continue
            at = self.at[side]
            rising = told[side] * at >= 0 and abs(told[side]) > abs(at)
            most = (self.law.up if rising else self.law.down) * 0.002
            self.at[side] = at + max(-most, min(most, told[side] - at))
        return self.at[0], self.at[1]


@register
@dataclass(frozen=True)
class SoftStart(Law):
    """The driver ramps its output at `up` per second, and down at another rate."""

    label, law, grows, span = "motor_asymmetric_lag", "soft_start", {"up": -1, "down": -1}, (0.15, 20.0)
    cause = "soft-start ramps of motor drivers (RoboClaw acceleration setting, Sabertooth ramping mode)"
    sides: Sides
    up: float
    down: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw both rates; one of them is faster."""
        slow = log_uniform(rng, 0.6, 3.0)
        fast = slow * log_uniform(rng, 3.0, 10.0)
        return cls(which(rng, 0.3), *((slow, fast) if rng.random() < 0.7 else (fast, slow)))

    def process(self, rng: Rng) -> Process:
        """Return the ramp."""
        return Ramp(self)


class TwoFilters(Process):
    """A first-order filter with one time constant for rising and another for falling commands."""

    def __init__(self, law: LazyDriver) -> None:
        self.law, self.at = law, [0.0, 0.0]

    def command(self, state: State, left: float, right: float) -> tuple[float, float]:
        """Return the filtered commands."""
        told = (left, right)
        for side in (0, 1):
            if not self.law.sides[side]:
                self.at[side] = told[side]
                continue
            lag = self.law.up_s if abs(told[side]) > abs(self.at[side]) else self.law.down_s
            self.at[side] += (told[side] - self.at[side]) * min(0.002 / lag, 1.0)
        return self.at[0], self.at[1]


@register
@dataclass(frozen=True)
class LazyDriver(Law):
    """An input filter charges through one resistance and discharges through another."""

    label, law, grows, span = (
        "motor_asymmetric_lag",
        "charge_discharge",
        {"up_s": 1, "down_s": 1},
        (0.01, 2.0),
    )
    cause = "RC-filtered analogue speed input with a diode across the resistor (any RC with a bypass diode)"
    sides: Sides
    up_s: float
    down_s: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw both time constants."""
        slow = log_uniform(rng, 0.1, 0.5)
        fast = slow / log_uniform(rng, 2.0, 8.0)
        return cls(which(rng, 0.3), *((slow, fast) if rng.random() < 0.6 else (fast, slow)))

    def process(self, rng: Rng) -> Process:
        """Return the filter."""
        return TwoFilters(self)
