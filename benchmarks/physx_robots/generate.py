"""Make recordings of simulated robots in PhysX, each with a hidden imperfection, and the key that says which.

    python benchmarks/physx_robots/generate.py --seed 1 --robots 24 --out DIR [--only 0,3] [--verbose]

Robot i depends on the seed and on i alone. The key is written after each robot; robots that are in it already
and are not made again stay.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np

from benchmarks.physx_robots.case import RUNS, Bench, Case, built, make_case
from benchmarks.physx_robots.plan import task_of
from benchmarks.physx_robots.sensing import Seen, floor_of, look, record, reported
from fsm_calib.recording.writers import write_recording


def plain(value: Any) -> Any:
    """Return a value with Python's own numbers, rounded to seven digits."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, bool | np.bool_):
        return bool(value)
    if isinstance(value, int | np.integer):
        return int(value)
    return float(f"{value:.7g}") if isinstance(value, float | np.floating) else value


def watch(case: Case) -> list[Seen]:
    """Return what the camera sees of each run."""
    bench = Bench(case.robot, case.seed, np.random.default_rng(0))
    for law in case.laws:
        bench.rngs([law], 0)
    robot = built(case.robot, case.laws)
    seen = []
    for run, drive in enumerate(case.drives):
        poses = reported(robot, case.laws, drive, bench.rngs(case.laws, run))
        seen.append(look(np.random.default_rng([31, *case.seed, run]), case.robot, poses))
    return seen


def key_of(name: str, case: Case, seen: list[Seen]) -> dict[str, Any]:
    """Return the key's entry."""
    whole = built(case.robot, case.laws)
    share = whole.mass / whole.total_mass
    effects = [
        {
            "label": law.label,
            "law": law.law,
            "cause": law.cause,
            "size": law.sizes(),
            "sizes": law.sizes(),  # the scoring reads this name
            "ratio": size.ratio,
            "position": size.position,
            "heading": size.heading,
            "windows": size.windows,
        }
        for law, size in zip(case.laws, case.sizes)
    ]
    strongest = max(effects, key=lambda e: e["ratio"])["label"] if effects else None  # type: ignore[arg-type,return-value]
    sensing = whole.sensing
    return plain(  # type: ignore[no-any-return]
        {
            "name": name,
            "family": case.task.family,
            "engine": "physx",
            "labels": [e["label"] for e in effects if e["label"]],
            "strongest": strongest,
            "effects": effects,
            "departures": case.robot.departures,
            "robot": {
                "kind": whole.kind,
                "mass": whole.total_mass,
                "centre_x": whole.centre[0] * share,
                "centre_y": whole.centre[1] * share,
                "axle": whole.axle,
                "radius": [w.radius for w in whole.wheels],
                "drive": "speed" if whole.controller else "duty",
                "tyre": "brush" if whole.tyre.brush else "engine",
                "caster": whole.casters[0].kind,
                "casters": len(whole.casters),
                "lag_s": whole.lag,
                "speed": whole.speed,
            },
            "sensing": {
                "position_sd": sensing.position_sd,
                "heading_sd": sensing.heading_sd,
                "rate": sensing.rate,
                "tails": sensing.tails,
                "missing": sensing.missing,
                "tag": sensing.tag,
                "tag_yaw": sensing.tag_yaw,
                "ticks": sensing.ticks,
            },
            "floor": {run: floor_of(s) for run, s in zip(RUNS, seen)},
            "departures_ratio": case.small[0],
            "friction_ratio": case.small[1],
            "attempt": case.attempt,
        }
    )


def make(folder: Path, seed: int, index: int, verbose: bool) -> dict[str, Any]:
    """Make one robot, write its recordings and return its entry."""
    start = time.perf_counter()
    name = f"robot-{index:03d}"
    case = make_case(task_of(seed, index), seed, index, verbose)
    seen = watch(case)
    for run, drive, view in zip(RUNS, case.drives, seen):
        write_recording(record(case.robot, drive, view), folder / name / run)
    entry = key_of(name, case, seen)
    if verbose:
        what = " + ".join(f"{e['label']}/{e['law']} {e['ratio']:.2f}" for e in entry["effects"]) or "nothing"
        spent = time.perf_counter() - start
        print(f"{name} {entry['family']} {entry['robot']['kind']}: {what} ({spent:.0f} s)", flush=True)
    return entry


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--robots", type=int, default=24)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--only", default="", help="robots by number, separated by commas")
    parser.add_argument("--verbose", action="store_true")
    args = parser.parse_args()
    wanted = [int(i) for i in args.only.split(",")] if args.only else list(range(args.robots))
    args.out.mkdir(parents=True, exist_ok=True)
    path = args.out / "keys.json"
    for index in wanted:
        entry = make(args.out, args.seed, index, args.verbose)
        entries = {e["name"]: e for e in json.loads(path.read_text())} if path.exists() else {}
        entries[entry["name"]] = entry
        part = path.with_suffix(".part")
        part.write_text(json.dumps([entries[name] for name in sorted(entries)], indent=1) + "\n")
        part.replace(path)


if __name__ == "__main__":
    main()
