"""Simulate robots with hidden effects in Rapier; write their recordings and a key.

python benchmarks/rapier_robots/generate.py --seed 1 --robots 12 --out DIR [--only 0,3] [--verbose]
"""

from __future__ import annotations

import math
import sys
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.rapier_robots import (
    laws_body,
    laws_command,
    laws_floor,
    laws_motor,
    laws_outside,
    laws_sensing,
)
from benchmarks.rapier_robots.laws import GROUPS, LABELS, OUTSIDE, Law, group_of, laws_of
from benchmarks.rapier_robots.robots import described, draw_robot
from benchmarks.rapier_robots.sensing import recorded
from benchmarks.rapier_robots.simulate import RanOff
from benchmarks.rapier_robots.trial import RUNS, Effect, Trial, Unreachable, new_trial
from benchmarks.robot_sets.command_line import main
from fsm_calib.recording.writers import write_recording

MODULES = (laws_body, laws_command, laws_floor, laws_motor, laws_outside, laws_sensing)  # they add their laws
BLOCK = ["plain"] * 29 + ["faint"] * 6 + ["pair"] * 7 + ["clean"] * 3 + ["outside"] * 5
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


def plan(seed: int, index: int) -> tuple[str, str, int]:
    """Return family and first label of a robot, and which of the label's laws has its turn."""
    block, place = divmod(index, len(BLOCK))
    family = evenly(np.random.default_rng([seed, 101, block]))[place]
    block, place = divmod(index, len(LABELS))
    label = LABELS[int(np.random.default_rng([seed, 102, block]).permutation(len(LABELS))[place])]
    turn = int(np.random.default_rng([seed, 103, LABELS.index(label)]).integers(6)) + block
    return family, label, turn


def choose(rng: Rng, family: str, label: str, turn: int, tries: int) -> list[Law]:
    """Return the laws of a robot; a pair's second label is of another kind."""
    if family == "clean":
        return []
    if family == "outside":
        laws = laws_of(OUTSIDE)
        return [laws[int(rng.integers(len(laws)))]]
    labels = [label]
    if family == "pair":
        others = [name for kind, names in GROUPS.items() if kind != group_of(label) for name in names]
        labels.append(str(rng.choice(others)))
    mine = [laws_of(name) for name in labels]
    firsts = [laws[int(rng.integers(len(laws)))] for laws in mine]
    if tries < 4:
        firsts[0] = mine[0][turn % len(mine[0])]
    return firsts


def attempt(rng: Rng, family: str, laws: list[Law]) -> Trial:
    """Return one draw of a robot with these laws, all sizes found; raises Unreachable."""
    needs = frozenset(need for law in laws for need in law.needs)
    if {"fork", "ball"} <= needs or {"duty", "speed"} <= needs:
        raise Unreachable("wants two kinds of robot at once")
    faint = family in ("faint", "clean")
    robot = draw_robot(rng, needs, faint)
    low, high = BANDS[family]
    goals = [math.exp(rng.uniform(math.log(1.12 * low), math.log(0.88 * high))) for _ in laws]
    trial = new_trial(rng, robot, laws, goals, (low, high), faint)
    trial.must_be_steady()
    trial.departures()
    for effect in trial.effects:
        trial.size_alone(effect)
    trial.final()
    return trial


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


def key_of(
    trial: Trial, name: str, family: str, tries: int, floors: list[dict[str, float]]
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
        "engine": "rapier",
        "departures": {k: round(v, 3) for k, v in trial.ratios.items() if v >= SHOWN},
        "departure_ratios": {k: round(v, 3) for k, v in trial.ratios.items()},
        "robot": described(trial.robot),
        "control": asdict(trial.robot.control) if trial.robot.control else None,
        "sheet": trial.robot.sheet,
        "sensing": asdict(trial.robot.sensing),
        "seconds": {run: round(s, 3) for run, s in zip(RUNS, trial.seconds)},
        "floor": {c: math.sqrt(float(np.mean([f[c] ** 2 for f in floors]))) for c in floors[0]},
        "floors": dict(zip(RUNS, floors)),
        "attempts": tries,
    }


def robot(seed: int, index: int, out: Path, verbose: bool) -> dict[str, Any]:
    """Make robot `index`: write its runs, return its key."""
    rng = np.random.default_rng([seed, index])
    family, label, turn = plan(seed, index)
    name, begun = f"robot-{index:03d}", time.process_time()
    for tries in range(1, TRIES + 1):
        if tries > SAME_LABEL:
            label = str(rng.choice(LABELS))
        try:
            trial = attempt(rng, family, choose(rng, family, label, turn, tries))
            break
        except (Unreachable, RanOff) as why:
            if verbose:
                print(f"{name}: {type(why).__name__}: {why}", flush=True)
    else:
        raise RuntimeError(f"{name}: no draw reached its band")
    setup, floors = trial.setup(trial.effects), []
    for run, folder in enumerate(RUNS):
        recording, floor = recorded(rng, name, setup, trial.drives[run], run)
        write_recording(recording, out / name / folder)
        floors.append(floor)
    key = key_of(trial, name, family, tries, floors)
    if verbose:
        what = ", ".join(f"{e['label']}/{e['law']} {e['ratio']}" for e in key["effects"])
        kind = f"{key['robot']['kind']} {key['robot']['control']}"
        print(f"{name}: {family}: {what or '-'}; {kind}; {key['departure_ratios']}", flush=True)
    print(f"{name}: {tries} tries, {time.process_time() - begun:.0f} s of processor time", flush=True)
    return key


if __name__ == "__main__":
    main(__doc__, robot)
