"""Who hides what in a set of robots of one engine; draws until the sizes are found, recordings and keys."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.robot_sets.driving import RanOff
from benchmarks.robot_sets.laws import OUTSIDE, Law
from benchmarks.robot_sets.sensing import recorded
from benchmarks.robot_sets.trial import RUNS, Effect, Physics, Trial, Unreachable, new_trial
from fsm_calib.recording.writers import write_recording

BLOCK = ["plain"] * 29 + ["faint"] * 6 + ["pair"] * 8 + ["clean"] * 3 + ["outside"] * 4
BANDS = {
    "clean": (1.0, 1.0),
    "plain": (2.5, 7.0),
    "pair": (2.5, 7.0),
    "outside": (2.5, 7.0),
    "faint": (1.3, 2.0),
}
SHOWN = 1.2  # ratio from which a departure is told in the key
TRIES = 30
SAME_LABEL = 24  # tries before another label is taken

Rng = np.random.Generator


def evenly(rng: Rng) -> list[str]:
    """Return the families of a block, shuffled such that every fifth of it has its share of each."""
    keyed = []
    for family in sorted(set(BLOCK)):
        count = BLOCK.count(family)
        shift = float(rng.uniform(0.0, 1.0))
        keyed += [((n + shift) / count, family) for n in range(count)]
    return [family for _, family in sorted(keyed)]


@dataclass(frozen=True)
class RobotSet:
    """What an engine brings to a set.

    groups : labels by kind; laws : of all labels, and those outside; draw_robot(rng, needs, faint) : a robot;
    described(robot) : what the key tells of it.
    """

    engine: str
    groups: Mapping[str, Sequence[str]]
    laws: Sequence[Law]
    physics: Physics
    draw_robot: Callable[[Rng, frozenset[str], bool], Any]
    described: Callable[[Any], dict[str, Any]]

    @property
    def labels(self) -> list[str]:
        """All labels, sorted."""
        return sorted(name for names in self.groups.values() for name in names)

    def laws_of(self, label: str) -> list[Law]:
        """Return the laws of a label."""
        return [law for law in self.laws if law.label == label]

    def plan(self, seed: int, index: int) -> tuple[str, str, int]:
        """Return family and first label of a robot, and which of the label's laws has its turn."""
        block, place = divmod(index, len(BLOCK))
        family = evenly(np.random.default_rng([seed, 101, block]))[place]
        labels = self.labels
        block, place = divmod(index, len(labels))
        label = labels[int(np.random.default_rng([seed, 102, block]).permutation(len(labels))[place])]
        turn = int(np.random.default_rng([seed, 103, labels.index(label)]).integers(6)) + block
        return family, label, turn

    def choose(self, rng: Rng, family: str, label: str, turn: int, tries: int) -> list[Law]:
        """Return the laws of a robot; a pair's second label is of another kind."""
        if family == "clean":
            return []
        if family == "outside":
            laws = self.laws_of(OUTSIDE)
            return [laws[int(rng.integers(len(laws)))]]
        labels = [label]
        if family == "pair":
            others = [name for names in self.groups.values() if label not in names for name in names]
            labels.append(str(rng.choice(others)))
        mine = [self.laws_of(name) for name in labels]
        firsts = [laws[int(rng.integers(len(laws)))] for laws in mine]
        if tries < 4:
            firsts[0] = mine[0][turn % len(mine[0])]
        return firsts

    def attempt(self, rng: Rng, family: str, laws: list[Law]) -> Trial:
        """Return one draw of a robot with these laws, all sizes found; raises Unreachable."""
        needs = frozenset(need for law in laws for need in law.needs)
        faint = family in ("faint", "clean")
        robot = self.draw_robot(rng, needs, faint)
        low, high = BANDS[family]
        goals = [math.exp(rng.uniform(math.log(1.12 * low), math.log(0.88 * high))) for _ in laws]
        trial = new_trial(self.physics, rng, robot, laws, goals, (low, high), faint)
        trial.departures()
        trial.must_be_steady()
        for effect in trial.effects:
            trial.size_alone(effect)
        trial.final()
        return trial

    def attempted(self, seed: int, index: int, tries: int, out: Path) -> dict[str, Any]:
        """Draw a robot for the `tries`-th time, write its runs, return its key; raises Unreachable or RanOff."""
        family, label, turn = self.plan(seed, index)
        rng = np.random.default_rng([seed, index, tries])
        name = name_of(index)
        if tries > SAME_LABEL:
            label = str(rng.choice(self.labels))
        trial = self.attempt(rng, family, self.choose(rng, family, label, turn, tries))
        setup, floors = trial.setup(trial.effects), []
        for run, folder in enumerate(RUNS):
            recording, floor = recorded(rng, name, setup, trial.drives[run], run)
            write_recording(recording, out / name / folder)
            floors.append(floor)
        return self.key_of(trial, name, family, tries, floors)

    def key_of(
        self, trial: Trial, name: str, family: str, tries: int, floors: list[dict[str, float]]
    ) -> dict[str, Any]:
        """Return the key of a robot."""
        effects = [told(trial, effect) for effect in trial.effects]
        labelled = [e for e in effects if e["label"] is not None]
        strongest = max(labelled, key=lambda e: e["ratio"], default=None)
        return {
            "name": name,
            "family": family,
            "labels": [e["label"] for e in labelled],
            "strongest": strongest["label"] if strongest else None,
            "effects": effects,
            "engine": self.engine,
            "departures": {k: round(v, 3) for k, v in trial.ratios.items() if v >= SHOWN},
            "departure_ratios": {k: round(v, 3) for k, v in trial.ratios.items()},
            "robot": self.described(trial.robot),
            "control": asdict(trial.robot.control) if trial.robot.control else None,
            "sheet": trial.robot.sheet,
            "sensing": asdict(trial.robot.sensing),
            "seconds": {run: round(s, 3) for run, s in zip(RUNS, trial.seconds)},
            "floor": {c: math.sqrt(float(np.mean([f[c] ** 2 for f in floors]))) for c in floors[0]},
            "floors": dict(zip(RUNS, floors)),
            "attempts": tries,
        }

    def tried(self, seed: int, index: int, tries: int, out: Path) -> dict[str, Any] | str:
        """Return the key of an attempt, or why it reached nothing."""
        try:
            return self.attempted(seed, index, tries, out)
        except (Unreachable, RanOff) as why:
            return f"{type(why).__name__}: {why}"


def told(trial: Trial, effect: Effect) -> dict[str, Any]:
    """Return the entry of one effect."""
    seen, law = effect.seen, effect.law
    if seen is None:
        raise Unreachable("not measured")
    sizes = law.apply(trial.setup([]), effect.size, effect.draw)
    entry: dict[str, Any] = {
        "label": None if law.label == OUTSIDE else law.label,
        "law": law.name,
        "ratio": round(seen.ratio, 3),
        "ratio_position": round(seen.position, 3),
        "ratio_heading": round(seen.heading, 3),
        "size": effect.size,
        "unit": law.unit,
        "sizes": sizes,
        "source": law.source,
    }
    if law.local:
        entry["windows_touched"] = list(seen.touched)
    return entry


Tried = Callable[[int, int, int, Path], dict[str, Any] | str]


def robot(tried: Tried, seed: int, index: int, out: Path, verbose: bool) -> dict[str, Any]:
    """Make robot `index`: write its runs, return its key."""
    name, begun = name_of(index), time.monotonic()
    for tries in range(1, TRIES + 1):
        key = tried(seed, index, tries, out)
        if isinstance(key, dict):
            break
        if verbose:
            print(f"{name}: {key}", flush=True)
    else:
        raise RuntimeError(f"{name}: no draw reached its band")
    if verbose:
        what = ", ".join(f"{e['label']}/{e['law']} {e['ratio']}" for e in key["effects"])
        print(
            f"{name}: {key['family']}: {what or '-'}; {key['robot']['kind']}; {key['departure_ratios']}",
            flush=True,
        )
    print(f"{name}: {tries} tries, {time.monotonic() - begun:.0f} s", flush=True)
    return key


def name_of(index: int) -> str:
    """Return a robot's name."""
    return f"robot-{index:03d}"
