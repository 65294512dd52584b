"""One robot of the set: drawn, driven, and sized until its effects are as large as its family asks for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.physx_robots.departures import data_sheet, smooth, with_friction_told
from benchmarks.physx_robots.driver import Driver
from benchmarks.physx_robots.laws import Law, log_uniform
from benchmarks.physx_robots.plan import Task, choose, joined_needs
from benchmarks.physx_robots.robots import Motor, Rng, Robot, change_motors, draw_robot
from benchmarks.physx_robots.sensing import reported
from benchmarks.physx_robots.simulate import Drive, Simulation, Source, replay
from benchmarks.physx_robots.sizing import Compared, Search, Size, size_of

RUNS = ("run-a", "run-b", "run-h")
BANDS = {"plain": (2.5, 7.0), "pair": (2.5, 7.0), "outside": (2.5, 7.0), "faint": (1.3, 2.0)}
INNER = 0.05  # share of a band left free at its ends when a size is aimed at
LEAST_WINDOWS = 5  # that a local effect must touch in each of run-a and run-b
TRIFLES = (0.0001, 0.001)  # shares by which a motor is changed to see whether a robot is chaotic
CALM, CALM_FAINT = 0.4, 0.25  # of noise: what that may do to a drive beyond the kinematic robot's numbers
UPRIGHT = 0.12  # rad that a robot may lean at most
SEEN = 1.4  # ratio of dry friction above which it counts as a departure
SMALL, SMALL_FAINT = 2.2, 1.7  # largest ratio of all departures together
TRIES, NEAR = 8, 0.12  # of the search for a size; how near in the logarithm is near enough
ATTEMPTS = 60


class Rejected(Exception):
    """This draw will not do; the message says why."""


@dataclass(frozen=True)
class Case:
    """A finished robot: `robot` without its laws, the laws as sized, drives and sizes (one for each law);
    small: the ratios of all small departures together, and of dry friction."""

    task: Task
    robot: Robot
    laws: tuple[Law, ...]
    drives: tuple[Drive, ...]
    sizes: tuple[Size, ...]
    seed: tuple[int, ...]
    attempt: int
    small: tuple[float, float]


def built(robot: Robot, laws: Sequence[Law]) -> Robot:
    """Return the robot with its laws built in."""
    for law in laws:
        robot = law.build(robot)
    return robot


class Bench:
    """Simulates a robot with any of its laws; remembers what it has simulated."""

    def __init__(self, robot: Robot, seed: Sequence[int], rng: Rng) -> None:
        self.robot, self.seed = robot, tuple(seed)
        self.durations = [float(round(rng.uniform(56.0, 69.0), 1)) for _ in RUNS]
        self.places: dict[tuple[str | None, str], int] = {}

    def rngs(self, laws: Sequence[Law], run: int) -> list[Rng]:
        """Return each law's own generator for a run: the same whatever other laws are on."""
        return [np.random.default_rng([*self.seed, 100 + run, self._place(law)]) for law in laws]

    def _place(self, law: Law) -> int:
        return self.places.setdefault((law.label, law.law), len(self.places))

    def drive(self, laws: Sequence[Law], run: int, source: Source | None = None) -> Drive:
        """Drive with laws; without a source the driver decides."""
        robot = built(self.robot, laws)
        processes = [law.process(rng) for law, rng in zip(laws, self.rngs(laws, run))]
        duration = self.durations[run]
        chosen = source or Driver(np.random.default_rng([*self.seed, 200 + run]), self.robot, duration)
        drive = Simulation(robot, [p for p in processes if p is not None]).run(chosen, duration)
        if not np.isfinite(drive.x).all() or np.hypot(drive.x, drive.y).max() > 3.0 * self.robot.reach + 1.0:
            raise Rejected("ran away")
        if drive.leaned > UPRIGHT:
            raise Rejected("tipped over")
        return drive

    def again(self, told: Drive, told_laws: Sequence[Law], laws: Sequence[Law], run: int) -> Drive:
        """Return a drive's commands told again with other laws; laws of sensing alone change no drive."""
        if [x for x in told_laws if not x.senses] == [x for x in laws if not x.senses]:
            return told
        return self.drive(laws, run, replay(told.command_time, told.command))

    def compare(
        self, told: Drive, laws: Sequence[Law], on: Sequence[Law], off: Sequence[Law], law: Law, run: int
    ) -> Compared:
        """Return a run that was driven with `laws`, with `on` and with `off`; `law` says where it acts."""
        with_drive, without_drive = self.again(told, laws, on, run), self.again(told, laws, off, run)
        with_poses = reported(built(self.robot, on), on, with_drive, self.rngs(on, run))
        without = reported(built(self.robot, off), off, without_drive, self.rngs(off, run))
        mask = law.touched(with_drive, self.rngs([law], run)[0]) if law.local else None
        return Compared(told, with_poses, without, mask)


def apart(bench: Bench, other: Robot, told: Drive, base: Drive) -> float:
    """Return by how much another robot drives run-a's commands otherwise, beyond the kinematic robot's numbers,
    over noise.
    """
    twin = Bench(other, bench.seed, np.random.default_rng(0))
    twin.durations = bench.durations
    drive = twin.drive([], 0, replay(told.command_time, told.command))
    poses = [reported(r, [], d, []) for r, d in ((other, drive), (bench.robot, base))]
    return size_of(bench.robot, [Compared(told, poses[0], poses[1], None)]).rms


def stronger(robot: Robot, share: float) -> Robot:
    """Return the robot with a left motor stronger by a share."""

    def change(motor: Motor) -> Motor:
        return replace(motor, stall=motor.stall * (1 + share), free=motor.free * (1 + share))

    return change_motors(robot, change, (1.0, 0.0))


def _check_robot(bench: Bench, bare: Robot, told: Drive, base: Drive, faint: bool) -> tuple[float, float]:
    """Return the ratios of the departures and of the friction that every robot has.

    A robot whose drive the departures, or a trifle, change too much is rejected.
    """

    def ratio(other: Robot) -> float:
        return float(np.sqrt(1.0 + apart(bench, other, told, base) ** 2))

    departures = ratio(bare)
    if departures > (SMALL_FAINT if faint else SMALL):
        raise Rejected(f"departures too large: {departures:.2f}")
    for share in TRIFLES:
        rms = apart(bench, stronger(bench.robot, share), told, base)
        if rms > (CALM_FAINT if faint else CALM):
            raise Rejected(f"chaotic: {rms:.2f}")
    return departures, ratio(smooth(bench.robot))


def _scale_to(
    bench: Bench,
    told: Drive,
    told_laws: Sequence[Law],
    law: Law,
    base: Drive,
    target: float,
    band: tuple[float, float],
) -> Law:
    """Return the law sized on run-a such that it alone has about the ratio `target`, or is well inside the band."""
    wanted = float(np.sqrt(target**2 - 1.0))
    low, high = (float(np.sqrt(edge**2 - 1.0)) for edge in (band[0] * (1 + INNER), band[1] * (1 - INNER)))
    search = Search(wanted)
    for step in range(TRIES):
        on = bench.compare(told, told_laws, [law], [law], law, 0)
        size = size_of(bench.robot, [replace(on, without=reported(bench.robot, [], base, []))])
        if law.local and size.windows[0] < LEAST_WINDOWS:
            raise Rejected("not met")
        if abs(np.log(max(size.rms, 1e-6) / wanted)) < NEAR or (step > 2 and low < size.rms < high):
            return law
        other = law.scaled(search.next(size.rms))
        if other == law:
            raise Rejected(f"at its limit with rms {size.rms:.2f} of {wanted:.2f}")
        law = other
    raise Rejected("size not found")


def _others(laws: Sequence[Law], law: Law) -> list[Law]:
    """Return the other laws that stay on while one is sized: those bound to a place would be met elsewhere
    without it.
    """
    return [x for x in laws if x is not law and (law.local or not x.local or x.senses)]


def _sizes(bench: Bench, drives: Sequence[Drive], laws: Sequence[Law]) -> list[Size]:
    found = []
    for law in laws:
        others = _others(laws, law)
        on = [x for x in laws if x is law or x in others]
        found.append(
            size_of(
                bench.robot, [bench.compare(d, laws, on, others, law, run) for run, d in enumerate(drives)]
            )
        )
    return found


def _met(law: Law, size: Size) -> bool:
    return not law.local or min(size.windows[:2]) >= LEAST_WINDOWS


def attempt_case(task: Task, seed: int, index: int, attempt: int) -> Case:
    """Draw and size one robot."""
    numbers = (seed, index, attempt)
    rng = np.random.default_rng([21, *numbers])
    kinds = choose(rng, task, attempt, seed)
    needs = joined_needs(kinds)
    if needs is None:
        raise Rejected("laws that contradict")
    robot, bare = data_sheet(rng, draw_robot(rng, needs))
    laws: list[Law] = [kind.draw(rng, robot) for kind in kinds]
    bench = Bench(robot, numbers, rng)
    for law in laws:
        bench.rngs([law], 0)
    told = bench.drive(laws, 0)
    base = bench.again(told, laws, [], 0)
    small = _check_robot(bench, bare, told, base, task.family == "faint")
    if small[1] > SEEN:
        robot = bench.robot = with_friction_told(robot)
    if not laws:
        return Case(
            task, robot, (), (told, bench.drive([], 1), bench.drive([], 2)), (), numbers, attempt, small
        )
    low, high = BANDS[task.family]
    targets = [log_uniform(rng, low * (1 + INNER), high * (1 - INNER)) for _ in laws]
    laws = [
        _scale_to(bench, told, laws, law, base, target, (low, high)) for law, target in zip(laws, targets)
    ]
    for _ in range(3):
        drives = [bench.drive(laws, run) for run in range(3)]
        sizes = _sizes(bench, drives, laws)
        if not all(_met(law, size) for law, size in zip(laws, sizes)):
            raise Rejected("not met in both runs")
        if all(low <= size.ratio <= high for size in sizes):
            return Case(task, robot, tuple(laws), tuple(drives), tuple(sizes), numbers, attempt, small)
        factors = [np.sqrt(t**2 - 1.0) / max(s.rms, 1e-3) for t, s in zip(targets, sizes)]
        laws = [law.scaled(float(np.clip(f, 0.3, 3.0))) for law, f in zip(laws, factors)]
    raise Rejected(f"ratios {[round(s.ratio, 2) for s in sizes]}")


def make_case(task: Task, seed: int, index: int, verbose: bool = False) -> Case:
    """Return a robot for a task; draws anew until one will do."""
    for attempt in range(ATTEMPTS):
        try:
            return attempt_case(task, seed, index, attempt)
        except Rejected as why:
            if verbose:
                print(f"  robot-{index:03d} attempt {attempt}: {why}", flush=True)
    raise RuntimeError(f"robot {index} of seed {seed} could not be made: {task}")
