"""One draw of a robot with its effects: drives, sizes that reach their bands, and departures."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchmarks.robot_sets.driver import Driver, start_of
from benchmarks.robot_sets.driving import Drive, RanOff, Robot, Setup, replay
from benchmarks.robot_sets.laws import SENSED, Draw, Law
from benchmarks.robot_sets.sizing import Seen, basis, compare, tell

FIRST = 26.0  # s of the drive on which departures and sizes are sought
RUNS = ("run-a", "run-b", "run-h")
STEADY = {True: 0.25, False: 0.4}  # of the noise: how much a trifle may show, for faint and other robots
MOST = {True: 1.7, False: 2.3}  # largest ratio of one departure of a robot


class Unreachable(Exception):
    """This draw does not give what was asked for."""


@dataclass
class Effect:
    """A law with its draw, its size as found, the ratio aimed at and its band."""

    law: Law
    draw: Draw
    size: float
    goal: float
    band: tuple[float, float]
    seen: Seen | None = None
    seconds: list[float] = field(default_factory=list)


@dataclass(frozen=True)
class Physics:
    """What an engine does with a robot.

    setup_of(robot) : it as it is; simulate(setup, tell, seconds, run, start) : a drive; departures : names of what it
    has besides; without(robot, name) : it without one of them; stronger(robot) : as it is, its left motor stronger by
    0.05 %.
    """

    setup_of: Callable[[Any], Any]
    simulate: Callable[..., Drive]
    departures: Iterable[str]
    without: Callable[[Any, str], Any]
    stronger: Callable[[Any], Any]


@dataclass
class Trial:
    """A robot, its three starts and lengths, and what was driven."""

    physics: Physics
    robot: Robot
    faint: bool
    seeds: list[int]
    starts: list[tuple[float, float, float]]
    seconds: list[float]
    effects: list[Effect] = field(default_factory=list)
    first: Drive | None = None
    drives: list[Drive] = field(default_factory=list)
    ratios: dict[str, float] = field(default_factory=dict)

    def setup(self, effects: list[Effect]) -> Setup:
        """Return the robot with some of its effects."""
        setup = self.physics.setup_of(self.robot)
        for effect in effects:
            effect.law.apply(setup, effect.size, effect.draw)
        return setup

    def live(self, setup: Setup, run: int, seconds: float | None = None) -> Drive:
        """Drive with the driver of a run, for its whole length or a part of it."""
        rng = np.random.default_rng(self.seeds[run])
        driver = Driver(rng, self.robot.area, self.robot.tick, 2 * self.robot.sensing.noise_xy)
        return self.physics.simulate(setup, driver, seconds or self.seconds[run], run, self.starts[run])

    def again(self, setup: Setup, drive: Drive, run: int, seconds: float | None = None) -> Drive:
        """Tell the commands of a drive again."""
        length = drive.seconds if seconds is None else min(seconds, drive.seconds)
        return self.physics.simulate(setup, replay(drive.commands, drive.tick), length, run, self.starts[run])

    def _base(self) -> Drive:
        if self.first is None:
            raise Unreachable("nothing driven yet")
        return self.first

    def ratio(self, setup: Setup, drive: Drive) -> float:
        """Return how much a robot that drove the first commands differs from the plain one."""
        base, robot = self._base(), self.robot
        plain, other = tell(self.setup([]), base, 0), tell(setup, drive, 0)
        return compare(robot, [other], [plain], [basis(robot, base)]).ratio

    def must_be_steady(self) -> None:
        """Raise Unreachable where a left motor stronger by 0.05 % drives visibly otherwise."""
        other = self.physics.stronger(self.robot)
        ratio = self.ratio(other, self.again(other, self._base(), 0))
        if math.sqrt(ratio**2 - 1.0) > STEADY[self.faint]:
            raise Unreachable(f"unsteady: {ratio:.3f}")

    def departures(self) -> None:
        """Find the ratio of each departure on the first drive; raise Unreachable where one is too large."""
        for name in self.physics.departures:
            setup = self.physics.setup_of(self.physics.without(self.robot, name))
            drive = self._base() if name == "tag" else self.again(setup, self._base(), 0)
            self.ratios[name] = self.ratio(setup, drive)
            if self.ratios[name] > MOST[self.faint]:
                raise Unreachable(f"{name} shows with {self.ratios[name]:.2f}")

    def size_alone(self, effect: Effect) -> None:
        """Find the size of one effect that reaches its goal on the first drive, by bisection of its logarithm."""
        base, plain = self._base(), self.setup([])
        told, columns = tell(plain, base, 0), basis(self.robot, base)
        sees_only = not _acts(effect)
        low, high = math.log(effect.law.low), math.log(effect.law.high)
        at = 0.5 * (low + high)
        for _ in range(7):
            effect.size = math.exp(at)
            setup = self.setup([effect])
            try:
                drive = base if sees_only else self.again(setup, base, 0)
                ratio = compare(
                    self.robot, [tell(setup, drive, 0)], [told], [columns], effect.law.local
                ).ratio
            except RanOff:
                ratio = math.inf
            if abs(math.log(ratio / effect.goal)) < 0.1:
                return
            low, high = (at, high) if ratio < effect.goal else (low, at)
            at = _next(at, ratio, effect.goal, low, high)
        if not math.isfinite(ratio) or abs(math.log(ratio / effect.goal)) > 0.35:
            raise Unreachable(f"{effect.law.label}/{effect.law.name}: {ratio:.2f} for {effect.goal:.2f}")

    def final(self) -> None:
        """Drive all runs with all effects and correct the sizes until every ratio lies in its band."""
        for _ in range(3):
            setup = self.setup(self.effects)
            self.drives = [self.live(setup, run) for run in range(3)]
            if self._measured():
                return
        raise Unreachable(", ".join(f"{e.law.name} {e.seen.ratio:.2f}" for e in self.effects if e.seen))

    def _measured(self) -> bool:
        """Measure each effect against the robot without it; return whether all lie in their bands."""
        setup, good = self.setup(self.effects), True
        columns = [basis(self.robot, drive) for drive in self.drives]
        told = [tell(setup, drive, run) for run, drive in enumerate(self.drives)]
        for effect in self.effects:
            rest = self.setup([e for e in self.effects if e is not effect])
            same = not _acts(effect)
            others = [d if same else self.again(rest, d, run) for run, d in enumerate(self.drives)]
            plain = [tell(rest, drive, run) for run, drive in enumerate(others)]
            seen = effect.seen = compare(self.robot, told, plain, columns, effect.law.local)
            effect.seconds = [float(d.touched.mean() * d.seconds) for d in self.drives]
            if effect.law.local and min(seen.touched[:2]) < 5:
                raise Unreachable(f"{effect.law.name}: hardly touched")
            if not effect.band[0] <= seen.ratio <= effect.band[1]:
                good = False
                step = math.log(math.sqrt((effect.goal**2 - 1) / max(seen.ratio**2 - 1, 0.01)))
                effect.size *= math.exp(min(max(step, -0.7), 0.7))
                if not effect.law.low <= effect.size <= effect.law.high:
                    raise Unreachable(f"{effect.law.name}: size out of range")
        return good


def _acts(effect: Effect) -> bool:
    """Return whether a law acts on the robot itself, not on how it is seen."""
    return effect.law.label not in SENSED


def _next(at: float, ratio: float, goal: float, low: float, high: float) -> float:
    """Return the next logarithm of a size: by the law that effects grow with size, within the bracket."""
    if math.isfinite(ratio) and ratio > 1.08:
        guess = at + 0.5 * math.log((goal**2 - 1.0) / (ratio**2 - 1.0))
        if low + 0.02 * (high - low) < guess < high - 0.02 * (high - low):
            return guess
    return 0.5 * (low + high)


def spots_of(rng: np.random.Generator, drive: Drive) -> tuple[tuple[float, float], ...]:
    """Return two places that the robot passes often [m]: the busiest of some, by time within a fifth of the area."""
    moving = np.hypot(np.gradient(drive.x), np.gradient(drive.y)) > 1e-4
    way = np.stack([drive.x, drive.y], axis=1)[moving][::10]
    reach = 0.2 * float(np.ptp(way, axis=0).max())
    found: list[tuple[float, float]] = []
    for _ in range(2):
        tries = way[rng.integers(len(way), size=8)] * 0.85
        busy = [(np.hypot(*(way - t).T) < reach).sum() for t in tries]
        best = tries[int(np.argmax(busy))]
        found.append((float(best[0]), float(best[1])))
    return tuple(found)


def new_trial(
    physics: Physics,
    rng: np.random.Generator,
    robot: Robot,
    laws: list[Law],
    goals: list[float],
    band: tuple[float, float],
    faint: bool,
) -> Trial:
    """Return a trial with its first drive and effects whose sizes are not yet found."""
    starts = [start_of(rng, robot.area) for _ in RUNS]
    seconds = [round(float(rng.uniform(55.0, 70.0)) / robot.tick) * robot.tick for _ in RUNS]
    seeds = [int(k) for k in rng.integers(2**31, size=3)]
    trial = Trial(physics, robot, faint, seeds, starts, seconds)
    trial.first = trial.live(trial.setup([]), 0, FIRST)
    for law, goal in zip(laws, goals):
        spots = spots_of(rng, trial.first)
        numbers = tuple(float(v) for v in rng.random(6))
        draw = Draw(numbers, int(rng.integers(2**31)), spots, min(seconds), robot.area)
        trial.effects.append(Effect(law, draw, math.sqrt(law.low * law.high), goal, band))
    return trial
