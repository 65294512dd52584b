"""Sets of explanations that laps leave open: told apart by driving where that can be, ended early where it cannot.

    python3 benchmarks/investigate_sets.py [--robots 20] [--seed 1] [--out out/investigate_sets.jsonl]

Half of the robots hide one effect of a set that laps on a closed track do not tell apart (`SETS`), each member in turn, of half
to all of its typical size; told apart means that the answer is that effect alone. The other half hide a plain delay of
commands or of poses (no smoothing, by which they differ), which are one without encoders: each must end by itself, name the delays as a set, and say what would
tell them apart. Robots, tracker and budget as in `investigate.py`. A call goes on where the one before ended.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path

import numpy as np
from kept_rows import kept_rows

from fsm_calib.runner.investigation.run import investigate
from fsm_calib.scenario.models import Scenario
from fsm_calib.world2d.effects import registry

SETS = (
    ("motor_deadband", "motor_gain_curve"),
    ("motor_deadband", "tyre_scrub"),
    ("caster_drag", "coulomb_friction"),
    ("tyre_scrub", "caster_drag"),
    ("floor_tilt", "carpet_nap"),
)
DELAYS = ("command_delay", "observation_delay")
EARLY = 45.0
"""Half of the budget [s]: what ends before it ended early."""


def hidden(number: int, seed: int) -> tuple[str, str]:
    """Return the effect that a robot hides and the one that it could be taken for."""
    if number % 2:
        first = (number // 2) % 2
        return DELAYS[first], DELAYS[1 - first]
    pair = SETS[(number // 2) % len(SETS)]
    first = (number // 2 // len(SETS) + seed) % 2
    return pair[first], pair[1 - first]


def robot(number: int, seed: int) -> Scenario:
    """Return a robot that hides one effect of a set."""
    name, _ = hidden(number, seed)
    share = float(np.random.default_rng([seed, number, 3]).uniform(0.5, 1.0))
    effect = {
        p.name: p.null + share * (p.typical - p.null) if p.strength else p.typical
        for p in registry()[name].parameters
        if name not in DELAYS or p.name == "delay"
    }
    return Scenario.model_validate(
        {
            "name": f"set-{number}",
            "seed": 9000 + number + 1000 * seed,
            "robot": {"effects": {name: effect}},
            "scene": {"boards": {"placed": ({"board": {}, "x": 3.0, "y": 0.0},)}},
            "investigate": {"budget": 90.0},
        }
    )


def one(number: int, seed: int) -> dict:
    with tempfile.TemporaryDirectory() as folder:
        _, result = investigate(robot(number, seed), Path(folder))
    truth, rival = hidden(number, seed)
    return {
        "robot": number,
        "truth": truth,
        "rival": rival,
        "ended": result["ended"],
        "seconds": result["robot"]["seconds"],
        "named": [effect["name"] for effect in result.get("effects", [])],
        "ambiguous": result.get("ambiguous", []),
        "reason": result["reason"],
    }


def is_told_apart(row: dict) -> bool:
    """Whether the answer is the hidden effect alone."""
    return row["named"] == [row["truth"]] and not row["ambiguous"]


def ends_early(row: dict) -> bool:
    """Whether an investigation of a delay ended by itself before half of its time, and left both delays open."""
    said = {name for names in row["ambiguous"] for name in names}
    return bool(
        row["ended"] == "given_up/nothing_to_learn" and row["seconds"] < EARLY and said >= set(DELAYS)
    )


def summary(rows: list[dict]) -> str:
    driven = [row for row in rows if row["truth"] not in DELAYS]
    delays = [row for row in rows if row["truth"] in DELAYS]
    lines = []
    if driven:
        seconds = np.median([row["seconds"] for row in driven])
        right = sum(map(is_told_apart, driven))
        lines.append(
            f"told apart: {right} of {len(driven)} sets, {seconds:.0f} s of robot time in the median"
        )
    if delays:
        seconds = np.median([row["seconds"] for row in delays])
        early = sum(map(ends_early, delays))
        lines.append(
            f"two delays: {early} of {len(delays)} end early and say so, {seconds:.0f} s in the median"
        )
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robots", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("out/investigate_sets.jsonl"))
    asked = parser.parse_args()
    asked.out.parent.mkdir(parents=True, exist_ok=True)
    rows = kept_rows(asked.out)
    with asked.out.open("a") as file:
        for number in sorted(set(range(asked.robots)) - {row["robot"] for row in rows}):
            rows.append(one(number, asked.seed))
            print(json.dumps(rows[-1]), file=file, flush=True)
    print(summary(rows))


if __name__ == "__main__":
    main()
