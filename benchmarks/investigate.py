"""Robots with hidden effects investigate themselves: designed drives against random ones and passive ones.

    python3 benchmarks/investigate.py --out out/investigate.jsonl             # about a minute of CPU for each robot
    python3 benchmarks/investigate.py --drawn 20 --seed 1 --out out/drawn.jsonl         # robots drawn from the catalogue
    python3 benchmarks/investigate.py --drawn 20 --seed 1 --poses camera --arms designed --out out/camera.jsonl
    python3 benchmarks/investigate.py --summary out/investigate.jsonl

Every robot is drawn from the fleet and driven in this project's own world (pymunk, 2 ms steps) under a tracker at
the ceiling; the investigation never sees the world's truth. Sizes: plain = the typical size of the effect's file,
masked = half of it, faint = a quarter. `--drawn` draws kinds, effects and sizes (within a quarter of these) from a seed that
no development saw, so that the robots are sealed until the summary is printed. A call goes on where the one before ended. Both arms have the same robot, noise seed, budget and rule to end.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from functools import partial
from pathlib import Path

import numpy as np
from concealed.drives import MIXED, Drive

from fsm_calib.diagnosis.design.area import Area
from fsm_calib.diagnosis.design.belief import Belief
from fsm_calib.diagnosis.design.designer import Composer, NoDrive, Wishes, design, random_drive
from fsm_calib.diagnosis.design.foresight import Foresight
from fsm_calib.diagnosis.design.plan import Plan
from fsm_calib.diagnosis.design.primitives import Primitive
from fsm_calib.journal import JOURNAL_NAME
from fsm_calib.runner.investigation.run import investigate
from fsm_calib.scenario.models import Scenario
from fsm_calib.types import Pose2
from fsm_calib.world2d.effects import registry

SIZES = {"plain": 1.0, "masked": 0.5, "faint": 0.25}
ROBOTS = (
    ("plain", "motor_deadband"), ("plain", "tyre_scrub"), ("plain", "floor_tilt"), ("plain", "caster_drag"),
    ("masked", "motor_gain_curve"), ("masked", "coulomb_friction"), ("masked", "motor_reverse_asymmetry"),
    ("faint", "motor_deadband"), ("faint", "motor_asymmetric_lag"), ("faint", "sensor_offset"),
    ("pair", "motor_deadband", "sensor_offset"), ("pair", "floor_tilt", "motor_gain_curve"),
    ("clean",), ("clean",), ("clean",), ("one set", "command_delay"),
)  # fmt: skip
KINDS = ("plain", "masked", "faint", "pair", "clean")
HIDDEN = (
    "motor_deadband", "command_saturation", "motor_gain_curve", "motor_reverse_asymmetry", "motor_asymmetric_lag",
    "coulomb_friction", "gear_backlash", "battery_sag", "wheel_eccentricity", "caster_drag", "tyre_scrub", "lateral_slip",
    "payload_offset", "floor_tilt", "carpet_nap", "rough_floor_patch", "low_friction_patch", "sensor_offset", "command_delay",
)  # fmt: skip
PLACES = {
    "tracker": {"scene": {"boards": {"placed": ({"board": {}, "x": 3.0, "y": 0.0},)}}},
    "camera": {
        "robot": {"known": {"camera": True}, "start": {"x": -0.9, "y": 0.0, "theta": 0.5}},
        "investigate": {"poses": "camera", "centre_x": -0.9, "width": 1.7, "depth": 1.4, "command": 0.4},
        "without": ("sensor_offset", "command_saturation"),
    },
}
"""What a scenario has where the poses come from a tracker over an empty floor, or from the robot's own camera over the
calibration area's markers, as in scenarios/investigate_camera.yaml; what is not drawn there: a robot that places itself has
no tracker that could sit elsewhere, and its commands end where the typical limit is."""
PIECE = 12.0
"""Least time of a random or passive drive, where there is room [s]."""
TRIED = 12
"""Passive manoeuvres that are tried until one stays within the bounds."""


def passive_drive(
    belief: Belief, area: Area, start: Pose2, rng: np.random.Generator, wishes: Wishes
) -> Plan | NoDrive:
    """Return a drive of a calibration's manoeuvres, as the concealed robots are driven, within the bounds."""
    composer = Composer.at(Foresight(belief), area, wishes, start, 1.0)
    weights, rows = np.array([weight for _, weight in MIXED]), composer.rows(rng)
    chosen: list[Primitive] = []
    while sum(p.duration for p in chosen) < PIECE:
        order = rng.choice(len(MIXED), TRIED, p=weights / weights.sum())
        options = (passive_manoeuvre(int(k), rng) for k in order)
        option = next((p for p in options if composer.stays([*chosen, p], rows)), None)
        if option is None:
            break
        chosen.append(option)
    chosen = composer.kept_safe(chosen, rng)
    return composer.plan(chosen, rng) if chosen else NoDrive.NO_ROOM


def passive_manoeuvre(kind: int, rng: np.random.Generator) -> Primitive:
    """Return one manoeuvre of the concealed robots."""
    drive, act = Drive(), MIXED[kind][0]
    act(drive, rng)
    spans = np.diff([*drive.times[1:], drive.end]).tolist()
    return Primitive(drive.states[-1], tuple(zip(spans, drive.left[1:], drive.right[1:], strict=True)))


ARMS = {"designed": design, "random": partial(random_drive, seconds=PIECE), "passive": passive_drive}
SAME = {"command_delay": "delay", "observation_delay": "delay"}


def drawn(seed: int, number: int, poses: str) -> tuple[str, ...]:
    """Kind and effects of a robot that a seed draws, of those that it can have and show where its poses come from."""
    kind, rng = KINDS[number % len(KINDS)], np.random.default_rng([seed, number])
    hidden = [name for name in HIDDEN if name not in PLACES[poses].get("without", ())]
    return (kind, *rng.choice(hidden, {"clean": 0, "pair": 2}.get(kind, 1), replace=False).tolist())


def effects(kind: str, names: tuple[str, ...], factor: float, centre_x: float) -> dict:
    """The hidden effects, each typical number moved towards the value that changes nothing, spots into the area."""
    share = factor * SIZES.get(kind, 1.0)
    hidden = {
        name: {
            p.name: min(max(p.null + share * (p.typical - p.null), p.low), p.high)
            if p.strength
            else p.typical
            for p in registry()[name].parameters
        }
        for name in names
    }
    for name in (n for n in names if registry()[n].scan == "place"):
        hidden[name]["x"] += centre_x
    return hidden


def robot(
    number: int, kind: str, names: tuple[str, ...], budget: float, seed: int | None, poses: str
) -> Scenario:
    place = PLACES[poses]
    factor = 1.0 if seed is None else float(np.random.default_rng([seed, number, 1]).uniform(0.75, 1.25))
    return Scenario.model_validate(
        {
            "name": f"robot-{number}",
            "seed": 1000 + number + 1000 * (seed or 0),
            "robot": {
                "effects": effects(kind, names, factor, place.get("investigate", {}).get("centre_x", 0.0)),
                **place.get("robot", {}),
            },
            "scene": place.get("scene", {}),
            "investigate": {"budget": budget, **place.get("investigate", {})},
        }
    )


def one(number: int, arm: str, budget: float, seed: int | None, poses: str) -> dict:
    began = time.process_time()
    kind, *names = ROBOTS[number] if seed is None else drawn(seed, number, poses)
    with tempfile.TemporaryDirectory() as folder:
        going, result = investigate(
            robot(number, kind, tuple(names), budget, seed, poses), Path(folder), designer=ARMS[arm]
        )
        answers = answers_of(Path(folder))
    truth = {SAME.get(name, name) for name in names}
    right = [{SAME.get(n, n) for n in answer} == truth for answer in answers]
    trace, area = going.connection.world.truth.trace, going.mind.area
    x, y = trace[:, 1], trace[:, 2]
    out = max(
        (x - area.x_high).max(), (area.x_low - x).max(), (y - area.y_high).max(), (area.y_low - y).max()
    )
    settled = next((k for k in range(len(right)) if all(right[k:])), None)
    return {
        "robot": number,
        "kind": kind,
        "truth": names,
        "arm": arm,
        "ended": result["ended"],
        "seconds": result["robot"]["seconds"],
        "right": bool(right and right[-1]),
        "seconds_to_right": None
        if settled is None
        else sum(d["seconds"] for d in result["drives"][: settled + 1]),
        "answers": answers,
        "said": [d["beliefs"][0] for d in result["drives"] if d["beliefs"]],
        "verdict": result.get("verdict"),
        "promises": [[d["expected"], d["reached"]] for d in result["drives"]],
        "nearest_edge_m": round(-float(out), 3),
        "wall": result["seconds"],
        "processor_s": round(time.process_time() - began, 2),
    }


def answers_of(folder: Path) -> list[list[str]]:
    """The names that each judgement would have answered: those of the verdict, where it has any."""
    rows = map(json.loads, (folder / JOURNAL_NAME).read_text().splitlines())
    return [row["evidence"]["names"] for row in rows if row.get("trigger") == "answer_judged"]


def summary(rows: list[dict]) -> str:
    lines = [
        "| arm | kind | robots | right at the end | median robot time driven to a right answer that stays |",
        "|---|---|---|---|---|",
    ]
    for arm in ARMS:
        for kind in dict.fromkeys(r["kind"] for r in rows):
            some = [r for r in rows if r["arm"] == arm and r["kind"] == kind]
            if not some:
                continue
            times = [r["seconds_to_right"] if r["seconds_to_right"] is not None else np.inf for r in some]
            middle = float(np.median(times))
            told = f"{middle:.0f} s" if np.isfinite(middle) else "never"
            told = told if some[0]["truth"] else "-"
            lines.append(f"| {arm} | {kind} | {len(some)} | {sum(_right(r) for r in some)} | {told} |")
    for other in list(ARMS)[1:]:
        pairs = [
            (_cost(a), _cost(b))
            for a in rows
            for b in rows
            if a["robot"] == b["robot"] and (a["arm"], b["arm"]) == ("designed", other) and a["truth"]
        ]
        if pairs:
            ahead, level = sum(a < b for a, b in pairs), sum(a == b for a, b in pairs)
            middle = [float(np.median(column)) for column in zip(*pairs, strict=True)]
            lines.append(
                f"designed ahead of {other} on {ahead} of {len(pairs)} robots, level on {level}; "
                f"median time to a right answer {middle[0]:.0f} s and {middle[1]:.0f} s"
            )
    promised = [p for r in rows if r["arm"] == "designed" for p in r["promises"] if p[1] is not None]
    for low in np.arange(0.3, 1.0, 0.1):
        some = [p for p in promised if low <= p[0] < low + 0.1]
        if some:
            expected, reached = np.mean(some, axis=0)
            lines.append(
                f"promised {low:.1f} to {low + 0.1:.1f}: {len(some)} drives, expected {expected:.2f}, reached {reached:.2f}"
            )
    lines.append(f"nearest any axle's centre came to an edge: {min(r['nearest_edge_m'] for r in rows):.2f} m")
    return "\n".join(lines)


def _right(row: dict) -> bool:
    """Whether the answer at the end is right: of a clean robot a verdict without a name, of others the names."""
    return bool(row["verdict"] == "match" if not row["truth"] else row["right"])


def _cost(row: dict) -> float:
    return row["seconds_to_right"] if row["seconds_to_right"] is not None else np.inf


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, default=Path("out/investigate.jsonl"))
    parser.add_argument("--budget", type=float, default=90.0)
    parser.add_argument("--robots", type=int, default=len(ROBOTS))
    parser.add_argument(
        "--drawn", type=int, default=0, help="so many drawn robots in place of the listed ones"
    )
    parser.add_argument("--seed", type=int, default=1, help="what draws them")
    parser.add_argument("--first", type=int, default=0, help="number of the first robot")
    parser.add_argument("--arms", nargs="+", default=list(ARMS), choices=list(ARMS))
    parser.add_argument(
        "--poses", default="tracker", choices=list(PLACES), help="where the robot's poses come from"
    )
    parser.add_argument("--summary", type=Path, help="only print the table of this file")
    asked = parser.parse_args()
    if asked.summary is None:
        asked.out.parent.mkdir(parents=True, exist_ok=True)
        known = asked.out.read_text().splitlines() if asked.out.exists() else []
        ended = {(row["robot"], row["arm"]) for row in map(json.loads, known)}
        seed = asked.seed if asked.drawn else None
        with asked.out.open("a") as file:
            for number in range(asked.first, asked.drawn or asked.robots):
                for arm in asked.arms:
                    if (number, arm) not in ended:
                        file.write(json.dumps(one(number, arm, asked.budget, seed, asked.poses)) + "\n")
                        file.flush()
    path = asked.summary or asked.out
    print(summary([json.loads(line) for line in path.read_text().splitlines()]))


if __name__ == "__main__":
    main()
