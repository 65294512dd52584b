"""Simulate small robots with hidden effects in the DART engine; write their recordings and a key.

python benchmarks/dart_robots/generate.py --seed 1 --robots 24 --out DIR
"""

from __future__ import annotations

import argparse
import json
import logging
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.dart_robots import laws_body, laws_motor
from benchmarks.dart_robots.maker import RUNS, Made, make
from benchmarks.dart_robots.sensing import counts, track
from benchmarks.dart_robots.truth import Trajectory, total_mass
from fsm_calib.recording.channels import CommandTrack, PoseTrack, WheelPair
from fsm_calib.recording.recording import Recording, RobotFacts
from fsm_calib.recording.writers import write_recording

LOG = logging.getLogger("dart_robots")
SHARES = {"faint": 0.10, "pair": 0.15, "clean": 0.05, "outside": 0.05}
LABELS = tuple(dict.fromkeys(law.label for law in (*laws_motor.LAWS, *laws_body.LAWS)))
GROUPS = {
    "drive": (
        "motor_deadband", "command_saturation", "motor_gain_curve", "motor_reverse_asymmetry", "motor_fault",
        "motor_asymmetric_lag", "coulomb_friction", "battery_sag", "motor_warmup", "gear_backlash",
    ),
    "delay": ("command_delay", "observation_delay", "clock_drift"),
    "wheel": ("wheel_eccentricity", "caster_drag", "tyre_scrub", "lateral_slip", "payload_offset"),
    "floor": ("floor_tilt", "carpet_nap", "rough_floor_patch", "low_friction_patch", "external_push"),
    "sensor": ("sensor_offset", "sensor_yaw", "misplaced_marker"),
}  # fmt: skip
"""Two effects of one group are not put on one robot: they would hide each other."""
APART = (
    {"coulomb_friction", "caster_drag"},
    {"coulomb_friction", "tyre_scrub"},
    {"coulomb_friction", "payload_offset"},
    {"gear_backlash", "lateral_slip"},
    {"motor_asymmetric_lag", "command_delay"},
    {"motor_asymmetric_lag", "observation_delay"},
)
"""Further pairs that are not put on one robot: near twins, or joints that exclude each other in `world`."""


@dataclass(frozen=True)
class Task:
    """One robot that is to be made."""

    name: str
    family: str
    labels: tuple[str, ...]
    seed: tuple[int, int]


def plan(seed: int, robots: int) -> list[Task]:
    """Deal families and labels: every label comes up once before any comes up again."""
    rng = np.random.default_rng(seed)
    number = {family: max(round(share * robots), int(robots >= 10)) for family, share in SHARES.items()}
    families = [family for family, count in number.items() for _ in range(count)][:robots]
    families += ["plain"] * (robots - len(families))
    rng.shuffle(families)
    deck: list[str] = []
    dealt: dict[int, tuple[str, ...]] = {}
    # pairs are dealt first, while there is choice
    for index in sorted(range(robots), key=lambda k: families[k] != "pair"):
        dealt[index] = _deal(rng, deck, families[index])
    return [Task(f"robot-{k:03d}", families[k], dealt[k], (seed, k)) for k in range(robots)]


def _deal(rng: np.random.Generator, deck: list[str], family: str) -> tuple[str, ...]:
    if family == "clean":
        return ()
    if family == "outside":
        return ("outside",)
    if len(deck) < 2:
        deck.extend(str(label) for label in rng.permutation(LABELS) if label not in deck)
    first = deck.pop(0)
    if family != "pair":
        return (first,)
    for second in deck:
        if fits(first, second):
            deck.remove(second)
            return first, second
    raise RuntimeError(f"nothing left in the deck goes with {first}")


def fits(first: str, second: str) -> bool:
    """Return whether two effects may share a robot."""
    same = any(first in group and second in group for group in GROUPS.values())
    return not same and {first, second} not in APART


def recording(rng: np.random.Generator, made: Made, drive: Trajectory, name: str, run: str) -> Recording:
    """Return what one drive leaves behind."""
    setting = made.setting
    facts, sensing = setting.facts, setting.sensing
    poses = track(rng, drive, made.truth.watch, sensing)
    rows = np.ones(len(drive.command_time), dtype=bool)
    if sensing.log_changes:
        rows[1:] = (np.diff(drive.command_left) != 0) | (np.diff(drive.command_right) != 0)
    wheels = None
    if sensing.ticks_per_turn:
        tick = 2.0 * np.pi / sensing.ticks_per_turn
        at, left, right = counts(rng, drive, sensing)
        wheels = WheelPair(at, left * tick, right * tick, "rad", tick)
    return Recording(
        robot=RobotFacts(
            name=name,
            wheel_radius=round(facts.wheel_radius, 5),
            axle_length=round(facts.axle_length, 4),
            max_wheel_rate=round(facts.max_wheel_rate, 3),
        ),
        command=CommandTrack(drive.command_time[rows], drive.command_left[rows], drive.command_right[rows]),
        pose=PoseTrack(poses.time, poses.x, poses.y, poses.theta),
        wheel_angle=wheels,
        source=run,
    )


def key(task: Task, made: Made) -> dict[str, Any]:
    """Return a robot's entry in the key."""
    truth, setting = made.setting.truth, made.setting
    body, drive = truth.body, truth.drive
    effects = [
        {
            "label": effect.law.label,
            "law": effect.law.name,
            "ratio": round(ratio.value, 3),
            "ratio_position": round(ratio.position, 3),
            "ratio_heading": round(ratio.heading, 3),
            "windows_touched": round(ratio.touched, 3),
            "sizes": {effect.law.size: effect.size, **effect.details},
        }
        for effect, ratio in zip(made.effects, made.ratios)
    ]
    labels = [effect.law.label for effect in made.effects if effect.law.label != "outside"]
    strongest = None
    if labels:
        strongest = max(effects, key=lambda each: float(str(each["ratio"])))["label"]
    events = [asdict(moments) for moments in setting.moments]
    never = {"fault": "fault_", "push": "push_"}
    shown = [prefix for what, prefix in never.items() if any(e.law.touched == what for e in made.effects)]
    return {
        "name": task.name,
        "family": task.family,
        "labels": labels,
        "strongest": strongest,
        "effects": effects,
        "engine": "dart",
        "departures": made.departures,
        "robot": {
            "kind": body.kind,
            "control": drive.mode,
            "mass": total_mass(body),
            "axle_length": body.axle,
            "wheel_radius": body.radius,
            "max_wheel_rate": drive.top_rate,
            "centre_x": body.centre[0],
            "centre_y": body.centre[1],
            "caster": body.caster,
            "caster_x": body.caster_arm,
            "caster_friction": body.caster_grip,
            "tyre_friction": body.tyre_grip,
            "rolling_coefficient": body.rolling,
            "dry_friction_nm": drive.dry,
            "stall_torque_nm": [k * drive.volts / ohm for k, ohm in zip(drive.emf, drive.ohm)],
            "free_rate": [drive.volts / k for k in drive.emf],
            "data_sheet": asdict(setting.facts),
        },
        "sensing": asdict(setting.sensing) | {"tag": truth.watch.tag, "tag_yaw": truth.watch.tag_yaw},
        "seconds": dict(zip(RUNS, setting.seconds)),
        "events": {
            run: {k: v for k, v in each.items() if k.startswith(tuple(shown)) and np.isfinite(v)}
            for run, each in zip(RUNS, events)
        }
        if shown
        else {},
        "attempts": made.attempts,
    }


def work(task: Task, out: Path) -> dict[str, Any]:
    """Make a robot, write its recordings, return its entry in the key."""
    start = time.perf_counter()
    made = make([*task.seed], task.family, list(task.labels))
    rng = np.random.default_rng([*task.seed, 10_000])
    for run, drive in zip(RUNS, made.drives):
        write_recording(recording(rng, made, drive, task.name, run), out / task.name / run)
    LOG.info("%s: done in %.0f s", task.name, time.perf_counter() - start)
    return key(task, made)


def main() -> None:
    """Run the generator from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--robots", type=int, default=24)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--verbose", action="store_true", help="say what is being made (spoils a sealed set)")
    options = parser.parse_args()
    logging.basicConfig(level=logging.INFO if options.verbose else logging.WARNING, format="%(message)s")
    options.out.mkdir(parents=True, exist_ok=True)
    tasks = plan(options.seed, options.robots)
    keys: list[dict[str, Any]] = []
    if options.jobs == 1:
        results = (work(task, options.out) for task in tasks)
        _collect(results, keys, len(tasks), options.out)
    else:
        with ProcessPoolExecutor(options.jobs) as pool:
            _collect(pool.map(work, tasks, [options.out] * len(tasks)), keys, len(tasks), options.out)


def _collect(results: Any, keys: list[dict[str, Any]], total: int, out: Path) -> None:
    for entry in results:
        keys.append(entry)
        (out / "keys.json").write_text(json.dumps(keys, indent=1, allow_nan=False) + "\n", encoding="utf-8")
        print(f"{len(keys)} of {total} robots", flush=True)


if __name__ == "__main__":
    main()
