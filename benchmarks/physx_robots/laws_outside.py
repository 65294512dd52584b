"""Physics that no label describes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.signal import StateSpace, lsim

from benchmarks.physx_robots.laws import DUTY, Law, Process, Reported, direction, log_uniform, register
from benchmarks.physx_robots.robots import GRAVITY, Rng, Robot
from benchmarks.physx_robots.simulate import State

Vector = tuple[float, float]


class Cable(Process):
    """Pulls at the robot's rear towards an anchor once the slack is used up."""

    def __init__(self, law: Tether) -> None:
        self.law = law

    def force(self, state: State) -> None:
        """Add the cable's pull."""
        law, arm = self.law, 0.4 * state.robot.axle
        rx, ry = -arm * math.cos(state.yaw), -arm * math.sin(state.yaw)
        dx, dy = law.anchor[0] - state.x - rx, law.anchor[1] - state.y - ry
        apart = math.hypot(dx, dy)
        if apart <= law.slack_m:
            return
        pull = law.pull * state.robot.total_mass * GRAVITY * min((apart - law.slack_m) / 0.1, 1.0)
        state.push(pull * dx / apart, pull * dy / apart, rx, ry)


@register
@dataclass(frozen=True)
class Tether(Law):
    """A cable reel pulls with `pull` of the weight once the cable is out by `slack_m`."""

    law, grows, span, needs = "tether", {"pull": 1}, (0.003, 0.4), DUTY
    cause = "power or network cable on a spring reel"
    pull: float
    anchor: Vector
    slack_m: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw pull, anchor and slack."""
        far = robot.reach * float(rng.uniform(0.5, 1.2))
        return cls(log_uniform(rng, 0.03, 0.12), direction(rng, far), far * float(rng.uniform(0.5, 0.9)))

    def process(self, rng: Rng) -> Process:
        """Return the cable."""
        return Cable(self)


class Gust(Process):
    """A force that swings to and fro."""

    def __init__(self, law: Fan, phase: float) -> None:
        self.law, self.phase = law, phase

    def force(self, state: State) -> None:
        """Add the wind of a fan that sweeps past."""
        law = self.law
        sweep = math.exp(4.0 * (math.cos(2.0 * math.pi * state.t / law.period_s + self.phase) - 1.0))
        size = law.force * state.robot.total_mass * GRAVITY * sweep
        state.push(size * law.towards[0], size * law.towards[1])


@register
@dataclass(frozen=True)
class Fan(Law):
    """A swinging fan blows with up to `force` of the weight, each `period_s`."""

    law, grows, span, needs = "fan", {"force": 1}, (0.003, 0.4), DUTY
    cause = "oscillating pedestal fan beside the arena"
    force: float
    towards: Vector
    period_s: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw force, direction and period."""
        return cls(log_uniform(rng, 0.03, 0.15), direction(rng), float(rng.uniform(2.5, 7.0)))

    def process(self, rng: Rng) -> Process:
        """Return the wind."""
        return Gust(self, float(rng.uniform(-np.pi, np.pi)))


class Tank(Process):
    """Liquid that swings in a tank: a mass on a spring in the level plane."""

    def __init__(self, law: Slosh, step: float = 0.002) -> None:
        self.law, self.step = law, step
        self.at = [0.0, 0.0]  # of the world, from the body
        self.speed = [0.0, 0.0]
        self.body = [0.0, 0.0]

    def force(self, state: State) -> None:
        """Advance the liquid and add what it does to the body."""
        law, step = self.law, self.step
        omega = 2.0 * math.pi * law.hertz
        mass = law.share * state.robot.total_mass
        pulls = []
        for i, speed in enumerate((state.vx, state.vy)):
            spring = omega**2 * self.at[i] + 2.0 * law.damping * omega * (self.speed[i] - speed)
            self.speed[i] -= step * spring
            self.at[i] += step * (self.speed[i] - speed)
            pulls.append(mass * spring)
        state.push(*pulls)


@register
@dataclass(frozen=True)
class Slosh(Law):
    """A tank whose liquid, `share` of the robot's mass, swings at `hertz`."""

    law, grows, span, needs = "sloshing_tank", {"share": 1}, (0.01, 1.2), DUTY
    cause = "first sloshing mode of a half-full tank (Abramson, NASA SP-106, equivalent spring-mass model)"
    share: float
    hertz: float
    damping: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw mass, frequency and damping."""
        return cls(log_uniform(rng, 0.15, 0.6), float(rng.uniform(0.5, 1.2)), float(rng.uniform(0.02, 0.08)))

    def process(self, rng: Rng) -> Process:
        """Return the tank."""
        return Tank(self)


class Holding(Process):
    """Holds the command of its start while a gap lasts."""

    def __init__(self, gaps: list[tuple[float, float]]) -> None:
        self.gaps, self.held = gaps, (0.0, 0.0)

    def command(self, state: State, left: float, right: float) -> tuple[float, float]:
        """Return the held or the present command."""
        if not any(a <= state.t < b for a, b in self.gaps):
            self.held = (left, right)
        return self.held


@register
@dataclass(frozen=True)
class LostPackets(Law):
    """Now and then the commands of a while are lost and the last one holds; mean length `length_s`."""

    law, grows, span = "lost_packets", {"length_s": 1}, (0.03, 2.0)
    cause = "bursts of loss on a crowded radio channel (Gilbert-Elliott)"
    length_s: float
    every_s: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw length and spacing."""
        return cls(log_uniform(rng, 0.15, 0.6), float(rng.uniform(2.0, 5.0)))

    def process(self, rng: Rng) -> Process:
        """Return the gaps."""
        starts = 2.0 + np.cumsum(rng.exponential(self.every_s, 60))
        lengths = self.length_s * rng.exponential(1.0, 60).clip(0.2, 3.0)
        return Holding([(float(a), float(a + b)) for a, b in zip(starts, lengths) if a < 70])


@register
@dataclass(frozen=True)
class Mast(Law):
    """The tag rides on a mast that swings: `gain` times the sway of a pendulum of `hertz` under the base's
    acceleration.
    """

    law, grows, span, senses = "wobbling_mast", {"gain": 1}, (0.01, 20.0), True
    cause = "first bending mode of a thin mast (any structural dynamics text)"
    gain: float
    hertz: float
    damping: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw sway, frequency and damping."""
        return cls(log_uniform(rng, 0.3, 2.0), float(rng.uniform(0.7, 2.0)), float(rng.uniform(0.02, 0.08)))

    def observe(self, poses: Reported, rng: Rng) -> Reported:
        """Return the poses with the sway."""
        time, omega = poses["time"], 2.0 * np.pi * self.hertz
        system = StateSpace([[0, 1], [-(omega**2), -2 * self.damping * omega]], [[0], [-1]], [[1, 0]], [[0]])
        sway = []
        for key in ("bx", "by"):
            speed = np.gradient(poses[key], time)
            smooth = np.convolve(np.pad(speed, 7, mode="edge"), np.full(15, 1 / 15), "valid")
            sway.append(lsim(system, np.gradient(smooth, time), time)[1])
        return poses | {"x": poses["x"] + self.gain * sway[0], "y": poses["y"] + self.gain * sway[1]}


class Sleepy(Process):
    """Gives less after a command has stayed the same for a while."""

    def __init__(self, law: Watchdog) -> None:
        self.law, self.last, self.since = law, (0.0, 0.0), 0.0

    def command(self, state: State, left: float, right: float) -> tuple[float, float]:
        """Return the command, or less of it."""
        if (left, right) != self.last:
            self.last, self.since = (left, right), state.t
        if state.t - self.since < self.law.patience_s:
            return left, right
        return left * (1.0 - self.law.loss), right * (1.0 - self.law.loss)


@register
@dataclass(frozen=True)
class Watchdog(Law):
    """A watchdog takes `loss` of the command away once it has not changed for `patience_s`."""

    law, grows, span = "watchdog", {"loss": 1}, (0.01, 1.0)
    cause = "command time-outs that step down stale commands (e.g. ROS base drivers' cmd_vel timeout)"
    loss: float
    patience_s: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw loss and patience."""
        return cls(log_uniform(rng, 0.1, 0.5), float(rng.uniform(0.4, 1.0)))

    def process(self, rng: Rng) -> Process:
        """Return the watchdog."""
        return Sleepy(self)


class Compass(Process):
    """Steers towards a direction of the room."""

    def __init__(self, law: HeadingHold) -> None:
        self.law = law

    def command(self, state: State, left: float, right: float) -> tuple[float, float]:
        """Return the command with a correction while it is not zero."""
        law = self.law
        size = max(abs(left), abs(right))
        turn = law.gain * size * math.sin(law.order * (law.north - state.yaw))
        return left - turn, right + turn


@register
@dataclass(frozen=True)
class HeadingHold(Law):
    """Firmware steers towards compass directions, `order` of them in a turn, with `gain` of the command."""

    law, grows, span = "compass_assist", {"gain": 1}, (0.003, 0.5)
    cause = "driver-assistance firmware with a magnetometer, left switched on"
    gain: float
    north: float
    order: int

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw gain and direction."""
        return cls(log_uniform(rng, 0.03, 0.15), float(rng.uniform(-np.pi, np.pi)), int(rng.integers(1, 5)))

    def process(self, rng: Rng) -> Process:
        """Return the compass."""
        return Compass(self)
