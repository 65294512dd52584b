"""One draw of a robot with its effects; how effects are measured and sized is the ODE set's."""

from __future__ import annotations

import math

import numpy as np

from benchmarks.box2d_robots.laws import Draw, Law
from benchmarks.box2d_robots.parts import Robot, Setup, setup_of
from benchmarks.box2d_robots.robots import NUISANCES, without
from benchmarks.box2d_robots.simulate import Drive, replay, simulate
from benchmarks.ode_robots.driver import Driver, start_of
from benchmarks.ode_robots.sizing import basis, compare, tell
from benchmarks.ode_robots.trial import FIRST, MOST, RUNS, STEADY, Effect, Unreachable, spots_of
from benchmarks.ode_robots.trial import Trial as OdeTrial

__all__ = ["RUNS", "Effect", "Trial", "Unreachable", "new_trial"]


class Trial(OdeTrial):
    """A robot of this engine, its three starts and lengths, and what was driven."""

    robot: Robot

    def setup(self, effects: list[Effect]) -> Setup:
        """Return the robot with some of its effects."""
        setup = setup_of(self.robot)
        for effect in effects:
            effect.law.apply(setup, effect.size, effect.draw)
        return setup

    def live(self, setup: Setup, run: int, seconds: float | None = None) -> Drive:
        """Drive with the driver of a run, for its whole length or a part of it."""
        rng = np.random.default_rng(self.seeds[run])
        driver = Driver(rng, self.robot.area, self.robot.tick, 2 * self.robot.sensing.noise_xy)
        return simulate(setup, driver, seconds or self.seconds[run], run, self.starts[run])

    def again(self, setup: Setup, drive: Drive, run: int, seconds: float | None = None) -> Drive:
        """Tell the commands of a drive again."""
        length = drive.seconds if seconds is None else min(seconds, drive.seconds)
        return simulate(setup, replay(drive.commands, drive.tick), length, run, self.starts[run])

    def ratio(self, setup: Setup, drive: Drive) -> float:
        """Return how much a robot that drove the first commands differs from the plain one."""
        base, plain = self._base(), self.setup([])
        robot = self.robot
        return compare(robot, [tell(plain, base, 0)], [tell(setup, drive, 0)], [basis(robot, base)]).ratio

    def must_be_steady(self) -> None:
        """Raise Unreachable where a left motor stronger by 0.05 % drives visibly otherwise."""
        left, right = self.robot.plant.torque_const
        other = setup_of(self.robot.changed(torque_const=(left * 1.0005, right)))
        ratio = self.ratio(other, self.again(other, self._base(), 0))
        if math.sqrt(ratio**2 - 1.0) > STEADY[self.faint]:
            raise Unreachable(f"unsteady: {ratio:.3f}")

    def departures(self) -> None:
        """Find the ratio of each departure on the first drive; raise Unreachable where one is too large."""
        for name in NUISANCES:
            setup = setup_of(without(self.robot, name))
            drive = self._base() if name == "tag" else self.again(setup, self._base(), 0)
            self.ratios[name] = self.ratio(setup, drive)
            if self.ratios[name] > MOST[self.faint]:
                raise Unreachable(f"{name} shows with {self.ratios[name]:.2f}")


def new_trial(
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
    trial = Trial(robot, faint, seeds, starts, seconds)
    trial.first = trial.live(trial.setup([]), 0, FIRST)
    for law, goal in zip(laws, goals):
        spots = spots_of(rng, trial.first)
        numbers = tuple(float(v) for v in rng.random(6))
        draw = Draw(numbers, int(rng.integers(2**31)), spots, min(seconds), robot.area)
        effect = Effect(law, draw, math.sqrt(law.low * law.high), goal, band)
        trial.effects.append(effect)
    return trial
