"""Simulate small robots with hidden effects in Exudyn; write their recordings and a key.

python benchmarks/exudyn_robots/generate.py --seed 1 --robots 24 --out DIR [--only 0,3] [--verbose]
"""

from __future__ import annotations

import copy
import math
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.exudyn_robots.effects import Draw, Law
from benchmarks.exudyn_robots.effects_place import GROUPS, LABELS, OUTSIDE, group_of, laws_of
from benchmarks.exudyn_robots.robots import describe, draw, nuisances
from benchmarks.exudyn_robots.sensing import recorded
from benchmarks.exudyn_robots.trial import RUNS, Effect, Trial, Unreachable, new_trial
from benchmarks.robot_sets.command_line import main
from fsm_calib.recording.writers import write_recording

BLOCK = ["plain"] * 30 + ["faint"] * 6 + ["pair"] * 6 + ["clean"] * 3 + ["outside"] * 5
BANDS = {"plain": (2.5, 7.0), "pair": (2.5, 7.0), "outside": (2.5, 7.0), "faint": (1.3, 2.0)}
ATTEMPTS = 12


def plan(seed: int, index: int) -> tuple[str, str]:
    """Family and (first) label of a robot: shuffled blocks, so that shares and labels come out even."""
    block, place = divmod(index, len(BLOCK))
    family = BLOCK[int(np.random.default_rng([seed, 1, block]).permutation(len(BLOCK))[place])]
    block, place = divmod(index, len(LABELS))
    return family, LABELS[int(np.random.default_rng([seed, 2, block]).permutation(len(LABELS))[place])]


def _choose(rng: np.random.Generator, family: str, label: str) -> list[Law]:
    """Laws of the family; a pair's second label is of another kind."""
    if family == "clean":
        return []
    if family == "outside":
        laws = laws_of(OUTSIDE)
        return [laws[int(rng.integers(len(laws)))]]
    labels = [label]
    if family == "pair":
        others = [x for g, names in GROUPS.items() if g != group_of(label) for x in names]
        labels.append(str(rng.choice(others)))
    return [laws_of(x)[int(rng.integers(len(laws_of(x))))] for x in labels]


def _goal(rng: np.random.Generator, family: str) -> float:
    low, high = BANDS[family]
    return float(math.exp(rng.uniform(math.log(1.08 * low), math.log(0.93 * high))))


def attempt(rng: np.random.Generator, family: str, label: str) -> Trial:
    """One draw of a robot of this family and label; raises Unreachable."""
    laws = _choose(rng, family, label)
    needs = {n for x in laws for n in x.needs}
    if {"swivel", "ball"} <= needs:
        raise Unreachable("two casters wanted")
    base = draw(
        rng, "duty" if "duty" in needs else None, "swivel" in needs, "encoders" in needs, "ball" in needs
    )
    trial = new_trial(rng, base)
    for x in laws:
        told = Draw(rng.random(12), trial.spots, trial.seconds)
        trial.effects.append(Effect(x, told, math.sqrt(x.low * x.high), _goal(rng, family), BANDS[family]))
    trial.must_be_steady()
    for e in trial.effects:
        trial.size_alone(e)
    trial.final()
    trial.nuisance_ratios = trial.departures()
    return trial


def entry(trial: Trial, name: str, family: str, tries: int) -> dict[str, Any]:
    """The key of a robot."""
    found = []
    for e in trial.effects:
        sizes: dict[str, Any] = {}
        events = []
        for run in range(3):
            probe = copy.deepcopy(trial.base)
            e.draw.run = run
            sizes = e.law.apply(probe, e.size, e.draw)
            if e.law.label == "external_push":
                events.append(float(probe.par["push_from"][0]))
            elif e.law.label == "motor_fault":
                p = probe.par[0]
                events.append(
                    [
                        [float(a), float(b)]
                        for a, b in zip(p["fault_from"], p["fault_to"], strict=True)
                        if a < 1e8
                    ]
                )
        seen = e.seen
        assert seen is not None
        found.append(
            {
                "label": None if e.law.label == OUTSIDE else e.law.label,
                "law": e.law.name,
                "ratio": round(seen.ratio, 3),
                "ratio_position": round(seen.position, 3),
                "ratio_heading": round(seen.heading, 3),
                "windows_touched": round(seen.touched, 3),
                "size": e.size,
                "unit": e.law.unit,
                "sizes": {k: float(v) for k, v in sizes.items()},
            }
            | ({"seconds_touched": [round(s, 2) for s in seen.seconds]} if e.law.local else {})
            | ({"events": dict(zip(RUNS, events, strict=True))} if events else {})
        )
    labels = [f["label"] for f in found if f["label"] is not None]
    strongest = max((f for f in found if f["label"]), key=lambda f: f["ratio"], default=None)
    ratios = trial.nuisance_ratios
    sensing = vars(copy.deepcopy(trial.base.sensing))
    return {
        "name": name,
        "family": family,
        "labels": labels,
        "strongest": strongest["label"] if strongest else None,
        "effects": found,
        "engine": "exudyn",
        "departures": {k: round(v, 3) for k, v in ratios.items() if v >= 1.2},
        "nuisances": nuisances(trial.base) | {"ratios": {k: round(v, 3) for k, v in ratios.items()}},
        "robot": describe(trial.base),
        "sensing": {
            k: list(v) if isinstance(v, tuple) else v for k, v in sensing.items() if k not in effect_fields()
        },
        "seconds": dict(zip(RUNS, trial.seconds, strict=True)),
        "attempts": tries,
    }


def effect_fields() -> tuple[str, ...]:
    """Fields of the sensing that only effects set (their values are in the effects)."""
    return (
        "pose_delay",
        "pose_delay_swing",
        "clock_rate",
        "clock_bend",
        "marker_x",
        "marker_y",
        "marker_r",
        "marker_shift",
        "marker_turn",
    )


def robot(seed: int, index: int, out: Path, verbose: bool) -> dict[str, Any]:
    """Generates robot `index`: writes its runs, returns its key."""
    rng = np.random.default_rng([seed, index])
    family, label = plan(seed, index)
    name = f"robot-{index:03d}"
    begun = time.time()
    for tries in range(1, 3 * ATTEMPTS + 1):
        if tries > ATTEMPTS:
            label = str(rng.choice(LABELS))
        try:
            trial = attempt(rng, family, label)
            break
        except (Unreachable, FloatingPointError) as why:
            if verbose:
                print(f"{name}: {why}", flush=True)
    else:
        raise RuntimeError(f"{name}: no draw reached its band")
    for run, folder in enumerate(RUNS):
        setup = trial.setup(run, trial.effects)
        truth, commands = trial.truths[run], trial.commands[run]
        seen = recorded(name, setup.sheet, setup.sensing, truth, commands, rng)
        write_recording(seen, out / name / folder)
    key = entry(trial, name, family, tries)
    if verbose:
        what = ", ".join(f"{f['label']}/{f['law']} {f['ratio']}" for f in key["effects"])
        print(
            f"{name}: {family}: {what or '-'}; {key['robot']['kind']} {key['robot']['control']}; "
            f"{key['departures']}; {tries} tries, {time.time() - begun:.0f} s",
            flush=True,
        )
    return key


if __name__ == "__main__":
    main(__doc__, robot)
