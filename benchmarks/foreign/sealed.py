"""One sealed robot: draw it, size its effects, drive it three times, write recordings and the key apart."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from foreign.catalogue import FITTED, LAWS, Law
from foreign.drive import Drive, piloted, replay
from foreign.pilot import Pilot
from foreign.robots import Robot, build, draw_robot
from foreign.setup import Array, Place, Setup
from foreign.sizing import ratio
from foreign.writing import key, write

RUNS = ("run-a", "run-b", "run-h")
BOUNDS = {
    "plain": (2.0, 8.0),
    "faint": (1.15, 2.0),
    "masked": (1.3, 2.0),
    "outside": (2.0, 8.0),
    "pair": (2.0, 8.0),
    "triple": (2.0, 8.0),
}


@dataclass(frozen=True)
class Order:
    """What a robot shall be: name, family, labels and engine."""

    name: str
    family: str
    labels: tuple[str, ...]
    engine: str
    seed: int
    law: str = ""  # a law by name, for tests; empty = drawn
    mass: float = 0.0  # kg; 0 = drawn
    states_mass: bool = False  # whether the recordings say mass and inertia


@dataclass
class Effect:
    """A law with its size and its own dice."""

    law: Law
    size: float
    seed: int
    sizes: dict[str, Any] | None = None

    def on(self, setup: Setup) -> None:
        """Put the effect into a setup."""
        self.sizes = self.law.apply(setup, self.size, np.random.default_rng(self.seed))


@dataclass
class Bench:
    """A robot with everything that its three drives share."""

    order: Order
    robot: Robot
    effects: list[Effect]
    place: Place | None
    windows: dict[str, tuple[float, float] | None]
    seconds: dict[str, float]
    starts: dict[str, Array]
    small: float = 1.0
    engine: str = "planar"  # where it drives now: sizes are sought in the plane first, which is quick

    def setup(self, run: str, effects: list[Effect], small: float | None = None) -> Setup:
        """Return a fresh setup for a run with some effects."""
        salt = RUNS.index(run) + 1
        setup = build(
            self.robot,
            self.place,
            self.windows[run],
            salt,
            self.small if small is None else small,
            self.engine,
        )
        for effect in effects:
            effect.on(setup)
        return setup

    def seed(self, run: str) -> int:
        """Return the seed of a run's dice."""
        return self.robot.seed + 1000 * RUNS.index(run)

    def pilot(self, run: str) -> Pilot:
        """Return the run's operator."""
        rng = np.random.default_rng(self.seed(run) + 1)
        sheet = self.robot.sheet
        levels = np.sort(rng.uniform(0.2, 0.95, int(rng.integers(4, 7))))
        return Pilot(
            rng,
            sheet["wheel_radius"] * sheet["max_wheel_rate"],
            sheet["axle_length"],
            self.robot.parts["reach"],
            self.place,
            levels,
        )

    def drive(self, run: str, effects: list[Effect]) -> tuple[Setup, Drive]:
        """Let the operator drive."""
        setup = self.setup(run, effects)
        return setup, piloted(
            setup, self.starts[run], self.pilot(run), self.seconds[run], self.seed(run), self.rounding
        )

    def again(
        self, run: str, effects: list[Effect], like: Drive, small: float | None = None
    ) -> tuple[Setup, Drive]:
        """Drive by the commands of another drive."""
        setup = self.setup(run, effects, small)
        return setup, replay(
            setup, self.starts[run], like.times, like.duties, self.seconds[run], self.seed(run)
        )

    def rounding(self, duty: Array) -> Array:
        """Return what the log keeps of a command, as duties."""
        if self.robot.command != "twist":
            return np.round(duty, 5)
        return self.from_twist(np.round(self.to_twist(duty), 5))

    def to_twist(self, duty: Array) -> Array:
        """Duties (..., 2) -> v [m/s], omega [rad/s] by the data sheet."""
        sheet = self.robot.sheet
        speed = duty * sheet["wheel_radius"] * sheet["max_wheel_rate"]
        return np.stack(
            [speed.sum(axis=-1) / 2, (speed[..., 1] - speed[..., 0]) / sheet["axle_length"]], axis=-1
        )

    def from_twist(self, twist: Array) -> Array:
        """The other way round."""
        sheet = self.robot.sheet
        half = twist[..., 1] * sheet["axle_length"] / 2
        return np.stack([twist[..., 0] - half, twist[..., 0] + half], axis=-1) / (
            sheet["wheel_radius"] * sheet["max_wheel_rate"]
        )


def draw_bench(order: Order, attempt: int) -> Bench:
    """Draw everything about a robot but the sizes of its effects."""
    rng = np.random.default_rng([order.seed, attempt])
    robot = draw_robot(rng, order.name, order.engine, order.labels, order.mass)
    effects = []
    for label in order.labels:
        choice = [
            item for item in LAWS[label] if order.engine in item.engines and order.law in ("", item.name)
        ]
        effects.append(Effect(choice[int(rng.integers(len(choice)))], 1.0, int(rng.integers(2**31))))
    if order.engine == "drake":
        pieces = {k: v for e in effects for k, v in FITTED.get(e.law.name, {}).items()}
        robot = dataclasses.replace(robot, pieces=pieces)
    if order.family == "masked":
        sensing = {
            **robot.sensing,
            "noise": 0.003,
            "turn_noise": float(np.deg2rad(1.0)),
            "tails": 4.0,
            "rate": 10.0,
        }
        robot = dataclasses.replace(robot, sensing=sensing)
    place = draw_place(rng, robot, effects) if any(e.law.placed for e in effects) else None
    seconds = {run: float(rng.uniform(50, 75)) for run in RUNS}
    faulty = any(e.law.label == "motor_fault" for e in effects)
    windows: dict[str, tuple[float, float] | None] = {}
    for run in RUNS:
        start = float(rng.uniform(0.25, 0.6)) * seconds[run]
        windows[run] = (start, start + float(rng.uniform(8, 20) if faulty else 4.0))
        if run == "run-h" and rng.random() < 0.5:
            windows[run] = None
    reach = robot.parts["reach"]
    starts = {run: np.array([*rng.normal(0, 0.2 * reach, 2), rng.uniform(-np.pi, np.pi)]) for run in RUNS}
    return Bench(order, robot, effects, place, windows, seconds, starts)


def draw_place(rng: np.random.Generator, robot: Robot, effects: list[Effect]) -> Place:
    """Draw a part of the floor near the middle of the arena."""
    axle, reach = robot.parts["size"], robot.parts["reach"]
    marker = any(e.law.label == "misplaced_marker" for e in effects)
    big = float(rng.uniform(2.0, 3.2) if marker else rng.uniform(1.0, 2.2)) * axle
    outline = str(rng.choice(["ellipse", "ellipse", "rectangle", "strip"]))
    x, y = rng.normal(0, 0.2 * reach, 2)
    soft = float(rng.choice([0.0, 0.15, 0.5]))
    wide = big * float(rng.uniform(0.6, 1.0)) if outline != "strip" else 0.6 * big
    return Place(float(x), float(y), outline, big, wide, float(rng.uniform(-np.pi, np.pi)), soft)


def size_effect(bench: Bench, effect: Effect, base: dict[str, tuple[Setup, Drive]], target: float) -> float:
    """Find the size at which an effect shows as much as `target`; return the ratio that was reached."""
    local = effect.law.placed or effect.law.timed
    wanted, best = np.sqrt(target**2 - 1), (1e9, 1.0, 1.0)
    low = 0.002
    for _ in range(5):
        drives = [(*bench.again(run, [effect], drive), setup, drive) for run, (setup, drive) in base.items()]
        value = ratio(bench.robot, drives, local)
        shown = np.sqrt(max(value**2 - 1, 1e-6))
        off = abs(np.log(shown / wanted))
        if off < best[0]:
            best = (off, effect.size, value)
        if off < 0.12:
            break
        effect.size = float(
            np.clip(effect.size * np.clip((wanted / shown) ** 0.8, 0.2, 4.0), low, effect.law.most)
        )
    effect.size = best[1]
    return best[2]


def calm_departures(bench: Bench, target: float) -> float:
    """Shrink the small departures until they show at most 0.45 as much as the effect; return their ratio."""
    allowed = np.sqrt(1 + (0.45 * np.sqrt(target**2 - 1)) ** 2) if bench.effects else 1.2
    _setup, drive = bench.drive("run-a", [])
    value = 1.0
    for _ in range(4):
        value = ratio(
            bench.robot, [(*bench.again("run-a", [], drive), *bench.again("run-a", [], drive, 0.0))], False
        )
        if value <= allowed:
            break
        bench.small *= max(0.4, 0.9 * np.sqrt((allowed**2 - 1) / (value**2 - 1)))
    return value


def make(order: Order, folder: Path) -> dict[str, Any]:
    """Make one robot: write its recordings below `folder`, return its key."""
    for attempt in range(8):
        bench = draw_bench(order, attempt)
        rng = np.random.default_rng([order.seed, 77, attempt])
        low, high = BOUNDS.get(order.family, (2.0, 8.0))
        targets = [float(np.exp(rng.uniform(np.log(1.08 * low), np.log(0.85 * high)))) for _ in bench.effects]
        departures = calm_departures(bench, min(targets, default=1.2))
        base = {"run-a": bench.drive("run-a", [])}
        reached = [size_effect(bench, e, base, t) for e, t in zip(bench.effects, targets)]
        if any(not low * 0.95 <= value <= high * 1.1 for value in reached):
            continue
        bench.engine = order.engine
        for _ in range(3):
            drives = {"run-a": bench.drive("run-a", bench.effects)}
            shown = [final_ratio(bench, e, drives) for e in bench.effects]
            if all(low <= value <= high * 1.05 for value in shown):
                drives |= {run: bench.drive(run, bench.effects) for run in RUNS[1:]}
                if not visits(bench, drives):
                    break
                for run in RUNS:
                    write(bench, *drives[run], run, folder / order.name / run)
                return key(bench, shown, departures)
            for effect, target, value in zip(bench.effects, targets, shown):
                factor = np.sqrt((target**2 - 1) / max(value**2 - 1, 1e-4)) ** 0.8
                effect.size = float(np.clip(effect.size * np.clip(factor, 0.2, 4.0), 0.002, effect.law.most))
    raise RuntimeError(
        f"{order.name}: no size of {order.labels} ({order.law or 'any law'}) shows as {order.family}"
    )


def final_ratio(bench: Bench, effect: Effect, drives: dict[str, tuple[Setup, Drive]]) -> float:
    """How much one effect shows on the commands of the first final drive."""
    local = effect.law.placed or effect.law.timed
    setup, drive = drives["run-a"]
    alone = bench.again("run-a", [effect], drive) if len(bench.effects) > 1 else (setup, drive)
    return ratio(bench.robot, [(*alone, *bench.again("run-a", [], drive))], local)


def visits(bench: Bench, drives: dict[str, tuple[Setup, Drive]]) -> bool:
    """Return whether each run is in the place for a second at least."""
    if bench.place is None:
        return True
    for _, drive in drives.values():
        inside = sum(bench.place.inside(x, y) > 0.5 for x, y in drive.rows[::10, :2])
        if inside * 0.1 < 1.0:
            return False
    return True
