"""Make one robot of a set: draw it, find how strong its effects must be, drive it three times."""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.dart_robots import laws_body, laws_motor
from benchmarks.dart_robots.driver import Driver, Knows
from benchmarks.dart_robots.law import BOTH, PLACES, Details, Law, with_body, with_drive
from benchmarks.dart_robots.robots import KINDS, Facts, Sensing, draw_robot, draw_sensing
from benchmarks.dart_robots.simulate import Replay, simulate
from benchmarks.dart_robots.truth import Moments, Trajectory, Truth
from benchmarks.dart_robots.visible import Drives, Ratio, ratio

LOG = logging.getLogger("dart_robots")
RUNS = ("run-a", "run-b", "run-h")
FINE_STEP = 0.001  # s, of what is recorded
SEARCH_STEP = 0.002  # s, while a size is searched
BANDS = {"plain": (2.5, 7.0), "pair": (2.5, 7.0), "outside": (2.5, 7.0), "faint": (1.3, 2.0)}
AIMS = {"plain": (3.0, 6.0), "pair": (3.2, 5.8), "outside": (3.0, 6.0), "faint": (1.45, 1.8)}
ATTEMPTS, MOST_ATTEMPTS = 8, 40  # the second: while none of them could be brought near its band at all
TRIALS = 6
NEAR = 0.12  # a search ends when the ratio's excess is this close to its aim, as a share
FARTHEST = 2.2  # m from the centre that a drive may reach
CLEARLY = 1.3  # ratio at which a nuisance is listed among the departures


@dataclass(frozen=True)
class Effect:
    """One hidden effect: its law, drawn details and strength (0 to 1)."""

    law: Law
    details: Details
    strength: float

    @property
    def size(self) -> float:
        """The size in the law's unit."""
        return self.law.at(self.strength)

    def on(self, truth: Truth) -> Truth:
        """Return the robot with this effect."""
        return self.law.apply(truth, self.size, self.details)


@dataclass(frozen=True)
class Setting:
    """A healthy robot with its data sheet, sensing, driver's spot and the plan of its three drives."""

    truth: Truth
    facts: Facts
    sensing: Sensing
    spot: tuple[float, float]
    seconds: tuple[float, float, float]
    moments: tuple[Moments, Moments, Moments]
    seeds: tuple[int, int, int]
    starts: tuple[tuple[float, float, float], ...]

    def drive(self, truth: Truth, run: int, dt: float) -> Trajectory:
        """Drive a robot once with the driver at the controls."""
        knows = Knows(
            self.truth.drive.top_rate * float(np.mean(self.truth.body.radius)), self.truth.body.axle
        )
        rng = np.random.default_rng(self.seeds[run])
        tick = 1.0 / self.sensing.command_hz
        driver = Driver(rng, knows, tick, self.seconds[run], self.spot)
        return simulate(truth, driver, self.seconds[run], dt, self.moments[run], self.starts[run])

    def replay(self, truth: Truth, run: int, dt: float, commands: Trajectory) -> Trajectory:
        """Drive a robot by the commands of another drive."""
        source = Replay(commands, 1.0 / self.sensing.command_hz)
        return simulate(truth, source, self.seconds[run], dt, self.moments[run], self.starts[run])


@dataclass(frozen=True, eq=False)
class Made:
    """A finished robot."""

    family: str
    setting: Setting
    truth: Truth
    effects: tuple[Effect, ...]
    ratios: tuple[Ratio, ...]
    drives: tuple[Trajectory, ...]
    departures: dict[str, float]
    attempts: int


def variants(label: str) -> list[Law]:
    """Return the laws of a label; `outside` has those that no label fits."""
    laws = (*laws_motor.LAWS, *laws_body.LAWS, *laws_body.OUTSIDE)
    return [law for law in laws if law.label == label]


def same_motion(first: Truth, second: Truth) -> bool:
    """Return whether two robots move alike and are only seen differently."""
    return (first.body, first.drive, first.place) == (second.body, second.drive, second.place)


def draw_setting(rng: np.random.Generator, labels: list[str], fine: float) -> tuple[Setting, list[Law]]:
    """Draw a robot that can show these labels, and a law for each."""
    offers = [variants(label) for label in labels]
    modes = [m for m in BOTH if all(any(m in law.modes for law in offer) for offer in offers)]
    mode = modes[0] if len(modes) == 1 else str(rng.choice(BOTH, p=[0.45, 0.55]))
    kinds = [k for k in KINDS
             if all(any(k in law.kinds for law in offer) for offer in offers)]  # fmt: skip
    fitting: list[list[Law]] | None = None
    while fitting is None or not all(fitting):
        truth, facts = draw_robot(rng, str(rng.choice(kinds)), mode)
        caster, kind = truth.body.caster, truth.body.kind
        fitting = [
            [law for law in offer if mode in law.modes and kind in law.kinds and law.caster in ("", caster)]
            for offer in offers
        ]
    laws = [offer[int(rng.integers(len(offer)))] for offer in fitting]
    encoders = any(law.encoders for law in laws) or bool(rng.random() < 0.47)
    sensing = draw_sensing(rng, encoders, fine)
    bearing, far = float(rng.uniform(-math.pi, math.pi)), float(rng.uniform(0.4, 0.65))
    seconds = tuple(float(rng.integers(50, 76)) for _ in RUNS)
    moments = []
    for run, length in zip(RUNS, seconds):
        start = float(rng.uniform(0.15, 0.6)) * length
        end = start + float(rng.uniform(5.0, 14.0))
        if run == "run-h" and rng.random() < 0.5:
            start = end = math.inf
        push = float(rng.uniform(0.2, 0.8)) * length
        moments.append(Moments(start, end, push, int(rng.integers(1 << 31))))
    starts = tuple(
        (float(rng.uniform(-0.3, 0.3)), float(rng.uniform(-0.3, 0.3)), float(rng.uniform(-3.1, 3.1)))
        for _ in RUNS
    )
    setting = Setting(
        truth,
        facts,
        sensing,
        (far * math.cos(bearing), far * math.sin(bearing)),
        seconds,  # type: ignore[arg-type]
        tuple(moments),  # type: ignore[arg-type]
        tuple(int(rng.integers(1 << 31)) for _ in RUNS),  # type: ignore[arg-type]
        starts,
    )
    return setting, laws


def draw_details(rng: np.random.Generator, law: Law, setting: Setting) -> Details:
    """Draw a law's details; a patch lies at the driver's spot."""
    details = law.draw(rng, setting.truth)
    if law.touched in PLACES:
        details = details | {
            "x_m": details["x_m"] + setting.spot[0],
            "y_m": details["y_m"] + setting.spot[1],
        }
    return details


def excess(value: float) -> float:
    """Return what an effect adds, in noise: the ratio without its 1."""
    return math.sqrt(max(value**2 - 1.0, 1e-6))


def find_strength(
    setting: Setting, law: Law, details: Details, clean: Trajectory, aim: float
) -> tuple[float, float]:
    """Return the strength at which the ratio comes nearest to `aim` on run-a, and that ratio."""
    plain = setting.truth
    low, high = (0.0, excess(1.0)), (1.0, math.inf)
    strength, best = 0.6, (0.6, 1.0)
    for trial in range(TRIALS):
        truth = Effect(law, details, strength).on(plain)
        drive = clean if same_motion(truth, plain) else setting.replay(truth, 0, SEARCH_STEP, clean)
        value = ratio(
            truth, plain, [Drives(drive, clean, setting.moments[0])], setting.sensing, law.touched
        ).value
        if trial == 0 or abs(math.log(excess(value) / excess(aim))) < abs(
            math.log(excess(best[1]) / excess(aim))
        ):
            best = (strength, value)
        if abs(excess(value) / excess(aim) - 1.0) < NEAR:
            break
        if value < aim:
            if strength >= 1.0:
                break
            low = (strength, excess(value))
        else:
            if strength <= 0.0:
                break
            high = (strength, excess(value))
        strength = _next(law, strength, excess(value), excess(aim), low[0], high[0], math.isinf(high[1]))
    return best


def _next(
    law: Law, strength: float, now: float, aim: float, low: float, high: float, open_end: bool
) -> float:
    """Return the next strength to try: as if the excess grew with the size, kept between the brackets."""
    span = abs(math.log(law.strong / law.weak))
    guess = strength + math.log(aim / now) / span
    if open_end:
        return min(guess, 1.0)
    return min(max(guess, low + 0.15 * (high - low)), high - 0.15 * (high - low))


def make(seed: list[int], family: str, labels: list[str]) -> Made:
    """Make a robot with these labels; draw another robot where an effect cannot be brought into its band."""
    fallback: tuple[float, Made] | None = None
    for attempt in range(MOST_ATTEMPTS):
        if attempt >= ATTEMPTS and fallback is not None:
            break
        rng = np.random.default_rng([*seed, attempt])
        setting, laws = draw_setting(rng, labels, min(1.0, 0.25 * attempt))
        made = _attempt(rng, family, setting, laws, attempt)
        if made is None:
            continue
        miss = max([_miss(family, each.value) for each in made.ratios], default=0.0)
        if miss == 0.0:
            return made
        if fallback is None or miss < fallback[0]:
            fallback = (miss, made)
    if fallback is None:
        raise RuntimeError(f"no robot could be made that shows {labels}")
    LOG.warning("an effect stays outside its band by %.0f %%", 100 * fallback[0])
    return fallback[1]


def _miss(family: str, value: float) -> float:
    """Return by how much a ratio misses its family's band, as a share."""
    low, high = BANDS[family]
    return max(0.0, low / value - 1.0, value / high - 1.0)


def _attempt(
    rng: np.random.Generator, family: str, setting: Setting, laws: list[Law], attempt: int
) -> Made | None:
    clean = setting.drive(setting.truth, 0, SEARCH_STEP)
    effects: list[Effect] = []
    aims: list[float] = []
    for law in laws:
        details = draw_details(rng, law, setting)
        low, high = AIMS[family]
        aims.append(float(np.exp(rng.uniform(np.log(low), np.log(high)))))
        strength, value = find_strength(setting, law, details, clean, aims[-1])
        if _miss(family, value) > 0.25:
            LOG.info("attempt %d: a law reaches only %.2f at strength %.2f", attempt, value, strength)
            return None
        effects.append(Effect(law, details, strength))
    for _ in range(3):
        made = _drive(family, setting, effects, attempt)
        if made is None or all(_miss(family, each.value) == 0.0 for each in made.ratios):
            break
        effects = [
            replace(each, strength=_again(each, value.value, aim))
            for each, value, aim in zip(effects, made.ratios, aims)
        ]
    if made is None:
        return None
    return replace(made, departures=departures(setting, clean))


def _again(effect: Effect, value: float, aim: float) -> float:
    span = abs(math.log(effect.law.strong / effect.law.weak))
    return min(1.0, max(0.0, effect.strength + math.log(excess(aim) / excess(value)) / span))


def _drive(family: str, setting: Setting, effects: list[Effect], attempt: int) -> Made | None:
    """Drive a robot three times and measure each effect by leaving it out; None: it left the floor."""
    truth = setting.truth
    for effect in effects:
        truth = effect.on(truth)
    drives = tuple(setting.drive(truth, run, FINE_STEP) for run in range(3))
    for drive in drives:
        far = float(np.max(np.hypot(drive.x, drive.y)))
        path = float(np.sum(np.hypot(np.diff(drive.x), np.diff(drive.y))))
        jump = float(np.ptp(drive.height))
        if not np.isfinite(drive.x).all() or far > FARTHEST or path < 1.5 or jump > 0.012:
            LOG.info("attempt %d: reach %.2f m, path %.2f m, height range %.4f m", attempt, far, path, jump)
            return None
    ratios = []
    for effect in effects:
        without = setting.truth
        for other in effects:
            if other is not effect:
                without = other.on(without)
        pairs = []
        for run in range(3):
            still = drives[run]
            if not same_motion(truth, without):
                still = setting.replay(without, run, FINE_STEP, drives[run])
            pairs.append(Drives(drives[run], still, setting.moments[run]))
        ratios.append(ratio(truth, without, pairs, setting.sensing, effect.law.touched))
        each = [ratio(truth, without, [one], setting.sensing, effect.law.touched) for one in pairs]
        if any(one.touched < 0.02 for one in each[: 2 if effect.law.touched == "fault" else 3]):
            LOG.info("attempt %d: a drive does not touch the place of its effect", attempt)
            return None
        if effect.law.touched in PLACES and ratios[-1].touched > 0.65:
            LOG.info("attempt %d: the place covers too much of the drives", attempt)
            return None
    return Made(family, setting, truth, tuple(effects), tuple(ratios), drives, {}, attempt + 1)


def departures(setting: Setting, clean: Trajectory) -> dict[str, float]:
    """Return the ratios of the nuisances that show: the healthy robot against itself without each of them."""
    truth = setting.truth
    body = truth.body
    without = {
        "mass_behind": with_body(truth, centre=(0.1 * body.centre[0], 0.0, body.centre[2])),
        "rolling": with_drive(with_body(truth, rolling=0.0), dry=(0.0, 0.0)),
        "caster": with_body(truth, caster_grip=0.0, swivel_torque=0.0, caster_axle_torque=0.0),
        "viscous": with_drive(truth, viscous=(0.0, 0.0)),
        "tag": replace(truth, watch=replace(truth.watch, tag=(0.0, 0.0), tag_yaw=0.0)),
    }
    found = {}
    for name, other in without.items():
        drive = clean if same_motion(truth, other) else setting.replay(other, 0, SEARCH_STEP, clean)
        value = ratio(truth, other, [Drives(clean, drive, setting.moments[0])], setting.sensing).value
        if value >= CLEARLY:
            found[name] = round(value, 2)
    return found
