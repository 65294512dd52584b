"""Laws of time: commands that act late, poses that are stamped late, clocks that run apart."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from benchmarks.physx_robots.laws import Law, Process, Reported, log_uniform, register, sign
from benchmarks.physx_robots.robots import Rng, Robot
from benchmarks.physx_robots.simulate import State


class Line(Process):
    """Commands that act later: a queue of (time to act, left, right)."""

    def __init__(self) -> None:
        self.queue: deque[tuple[float, float, float]] = deque()
        self.now = (0.0, 0.0)
        self.last = (0.0, 0.0)

    def late(self, state: State) -> float:
        """Return the delay [s] of a command that arrives now."""
        raise NotImplementedError

    def command(self, state: State, left: float, right: float) -> tuple[float, float]:
        """Return the command that is due."""
        if (left, right) != self.last:
            self.last = (left, right)
            due = state.t + self.late(state)
            self.queue.append((max(due, self.queue[-1][0] if self.queue else due), left, right))
        while self.queue and self.queue[0][0] <= state.t + 1e-9:
            self.now = self.queue.popleft()[1:]
        return self.now


class Jittered(Line):
    """A delay of a constant part and a random one (gamma, shape 2)."""

    def __init__(self, constant: float, jitter: float, rng: Rng) -> None:
        super().__init__()
        self.constant, self.jitter, self.rng = constant, jitter, rng

    def late(self, state: State) -> float:
        """Return a drawn delay [s]."""
        return self.constant + (self.rng.gamma(2.0, 0.5 * self.jitter) if self.jitter else 0.0)


@register
@dataclass(frozen=True)
class Delay(Law):
    """Every command acts `delay_s` late."""

    label, law, grows, span = "command_delay", "constant", {"delay_s": 1}, (0.01, 0.6)
    cause = "serial bridge or radio link with a fixed latency"
    delay_s: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the delay."""
        return cls(log_uniform(rng, 0.04, 0.25))

    def process(self, rng: Rng) -> Process:
        """Return the line."""
        return Jittered(self.delay_s, 0.0, rng)


@register
@dataclass(frozen=True)
class BusyLink(Law):
    """Commands act late by a base and a random part of mean `jitter_s`, in order."""

    label, law, grows, span = "command_delay", "busy_link", {"delay_s": 1, "jitter_s": 1}, (0.01, 0.5)
    cause = "Wi-Fi queueing delay, long-tailed (e.g. Sui et al., MobiSys 2016, on Wi-Fi latency in the wild)"
    delay_s: float
    jitter_s: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw base and jitter."""
        base = log_uniform(rng, 0.04, 0.2)
        return cls(base, base * float(rng.uniform(0.15, 0.6)))

    def process(self, rng: Rng) -> Process:
        """Return the line."""
        return Jittered(self.delay_s, self.jitter_s, rng)


class Polled(Process):
    """Takes over the newest command once in a period, and acts on it one period later."""

    def __init__(self, period: float, phase: float) -> None:
        self.period, self.next = period, phase * period
        self.now, self.read = (0.0, 0.0), (0.0, 0.0)

    def command(self, state: State, left: float, right: float) -> tuple[float, float]:
        """Return the command of the poll before."""
        if state.t + 1e-9 >= self.next:
            self.next += self.period
            self.now, self.read = self.read, (left, right)
        return self.now


@register
@dataclass(frozen=True)
class SlowLoop(Law):
    """The robot polls its commands with period `period_s` and acts a loop later: one to two periods late."""

    label, law, grows, span = "command_delay", "slow_loop", {"period_s": 1}, (0.02, 0.5)
    cause = "single-threaded main loop that reads, computes and then writes (double-buffered commands)"
    period_s: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the period."""
        return cls(log_uniform(rng, 0.05, 0.25))

    def process(self, rng: Rng) -> Process:
        """Return the poll."""
        return Polled(self.period_s, float(rng.uniform()))


@dataclass(frozen=True)
class Stamping(Law):
    """A law that changes the poses' stamps; subclasses give `late` [s] at true times [s]."""

    senses = True

    def late(self, time: np.ndarray, rng: Rng) -> np.ndarray:
        """Return how late the stamps are."""
        raise NotImplementedError

    def observe(self, poses: Reported, rng: Rng) -> Reported:
        """Return the poses with other stamps, in order."""
        stamp = poses["stamp"] + self.late(poses["time"], rng)
        return poses | {"stamp": np.maximum.accumulate(stamp + 1e-9 * np.arange(len(stamp)))}


@register
@dataclass(frozen=True)
class LateFrames(Stamping):
    """Every pose is stamped `delay_s` late."""

    label, law, grows, span = "observation_delay", "constant", {"delay_s": 1}, (0.01, 0.6)
    cause = (
        "exposure, transfer and detection before the stamp is taken (camera drivers that stamp on arrival)"
    )
    delay_s: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the delay."""
        return cls(log_uniform(rng, 0.03, 0.25))

    def late(self, time: np.ndarray, rng: Rng) -> np.ndarray:
        """Return the constant."""
        return np.full(len(time), self.delay_s)


@register
@dataclass(frozen=True)
class LoadedTracker(Stamping):
    """Poses are stamped late by a delay that wanders with the tracker's load."""

    label, law, grows, span = "observation_delay", "loaded_tracker", {"delay_s": 1}, (0.01, 0.6)
    cause = (
        "queueing of frames in a tracker that shares its computer (any vision pipeline without source stamps)"
    )
    delay_s: float
    wander: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the mean delay and how far it wanders."""
        return cls(log_uniform(rng, 0.04, 0.2), float(rng.uniform(0.1, 0.4)))

    def late(self, time: np.ndarray, rng: Rng) -> np.ndarray:
        """Return the delay, with two slow waves."""
        a, b = rng.uniform(0, 2 * np.pi, 2)
        wave = 0.6 * np.sin(2 * np.pi * time / 17.0 + a) + 0.4 * np.sin(2 * np.pi * time / 5.3 + b)
        return self.delay_s * (1.0 + self.wander * wave)


@register
@dataclass(frozen=True)
class CheapOscillator(Stamping):
    """The clock of the poses runs at 1 + rate of the clock of the commands."""

    label, law, grows, span = "clock_drift", "rate", {"size": 1}, (0.0002, 0.02)
    cause = "RC oscillator of a microcontroller, 1 % off after calibration and more before (ATmega328P data sheet)"
    size: float
    sense: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw the rate."""
        return cls(log_uniform(rng, 0.0015, 0.01), sign(rng))

    def sizes(self) -> dict[str, Any]:
        """Return the signed rate."""
        return {"rate": self.sense * self.size}

    def late(self, time: np.ndarray, rng: Rng) -> np.ndarray:
        """Return a straight line from 0."""
        return self.sense * self.size * time


@register
@dataclass(frozen=True)
class WarmingOscillator(Stamping):
    """The same clock, whose rate sets in as the board warms."""

    label, law, grows, span = "clock_drift", "warming", {"size": 1}, (0.0002, 0.03)
    cause = "temperature coefficient of RC and ceramic oscillators (rate over temperature in the same data sheets)"
    size: float
    sense: float
    warm_s: float

    @classmethod
    def draw(cls, rng: Rng, robot: Robot) -> Self:
        """Draw rate and warming time."""
        return cls(log_uniform(rng, 0.002, 0.012), sign(rng), float(rng.uniform(8.0, 30.0)))

    def late(self, time: np.ndarray, rng: Rng) -> np.ndarray:
        """Return a line that bends up from 0."""
        return self.sense * self.size * (time - self.warm_s * (1.0 - np.exp(-time / self.warm_s)))
