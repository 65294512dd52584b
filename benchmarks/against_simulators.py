"""Pairs of robots in simulators that are not ours, which differ in one physical thing: is it named, and mended?

    python benchmarks/against_simulators.py [--engine mujoco|pybullet] [--pairs NAME,NAME] [--seed N] [--out FILE]

One of a pair is the real robot: seen by a tracker (20 Hz, 2 mm, 0.4 deg), shoved by random forces, with one thing more.
The other is the user's simulator: it can be called, and lacks that thing. `diagnose REAL REAL --holdout REAL REAL REAL
--simulator ...` is asked with the whole catalogue; every pair has shoves of its own. The last column but one is what a
simulator errs that has the real robot's own model: nothing can do better. A pair that is in the file already is not asked
again. Needs mujoco or pybullet (`python3 -m pip install mujoco pybullet`); one pair takes 1 to 2 minutes.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

from concealed.drives import make_drive
from engine.generate import draw_robot, likeness
from engine.world import Robot
from kept_rows import kept_rows

from fsm_calib.diagnosis.against import Against, diagnose_against
from fsm_calib.diagnosis.around import Around, around, simulated_recordings
from fsm_calib.recording.channels import CommandTrack, PoseTrack
from fsm_calib.recording.recording import Recording, RobotFacts

PAIRS: dict[str, tuple[dict[str, float], str]] = {
    "deadband": ({"deadband": 0.06}, "motor_deadband"),
    "saturation": ({"saturation": 0.3}, "command_saturation"),
    "reverse": ({"reverse": 0.12}, "motor_reverse_asymmetry"),
    "tilt": ({"tilt_x": 0.03, "tilt_y": -0.02}, "floor_tilt"),
    "delay": ({"delay": 0.12}, "command_delay"),
    "scrub": ({"scrub": 0.006}, "tyre_scrub"),
    "equal": ({}, ""),
}
"""What the real robot has more, and the name it has in the catalogue; equal ones have none."""
BAR = 1.1  # held-out error over the noise's floor
RATE, DURATION = 20.0, 40.0  # Hz, s
HELD_OUT = 3  # drives: in one of 40 s a floor's share is told to a quarter, as shoves remember each other
NOISE = (0.002, 0.002, np.deg2rad(0.4))  # m, m, rad


def engine_of(name: str):
    """Return the simulator's `simulate`."""
    if name == "mujoco":
        from engine.world import simulate
    else:
        from engine.bullet import simulate
    return simulate


def called(robot: Robot, simulate):
    """Return the robot as `--simulator` takes one: command columns in, poses (n, 4) out."""

    def drive(commands):
        held = SimpleNamespace(
            times=commands["time"][:-1], left=commands["left"][:-1], right=commands["right"][:-1]
        )
        times, states = simulate(robot, held, np.zeros(3), commands["time"][-1] + 0.05, None)
        return np.column_stack([times, states[:, :3]])

    return drive


def recorded(robot: Robot, simulate, seed: list[int], profile: str) -> Recording:
    """Return a drive of the real robot, as its tracker saw it."""
    rng = np.random.default_rng(seed)
    drive = make_drive(rng, likeness(robot), np.zeros(3), profile, DURATION)
    times, states = simulate(robot, drive, np.zeros(3), drive.end, rng)
    stamps = np.arange(0.3, drive.end - 0.1, 1.0 / RATE)
    seen = np.column_stack([np.interp(stamps, times, states[:, i]) for i in range(3)])
    seen = seen + rng.standard_normal(seen.shape) * NOISE
    return Recording(
        RobotFacts(
            "real",
            wheel_radius=robot.radius,
            axle_length=round(robot.axle, 3),
            max_wheel_rate=round(robot.no_load, 1),
        ),
        command=CommandTrack(*drive.arrays()),
        pose=PoseTrack(stamps, *seen.T),
        source="-".join(map(str, (profile, *seed))),
    )


def asked(engine: str, pair: str, seed: int) -> dict:
    """Return the row of one pair."""
    simulate = engine_of(engine)
    more, name = PAIRS[pair]
    place = [seed, list(PAIRS).index(pair)]
    plain = draw_robot(np.random.default_rng(place))
    real, own = plain._replace(**more), called(plain, simulate)
    train = [recorded(real, simulate, [*place, i], "mixed") for i in range(2)]
    new = [recorded(real, simulate, [*place, 2 + i], "held_out") for i in range(HELD_OUT)]
    began, cpu = time.perf_counter(), time.process_time()
    found = diagnose_against(train, simulated_recordings(own, train, seed), new, seed=seed)
    errors, perfect = around(found, own, seed), around(found, called(real, simulate), seed).before
    cost = {"wall": time.perf_counter() - began, "cpu": time.process_time() - cpu}
    row = {"engine": engine, "pair": pair, "seed": seed, "cost": cost} | judged(found, errors, name)
    row["errors"]["perfect"] = {"xy_m": perfect.xy_m, "theta_rad": perfect.theta_rad}
    return row


def judged(found: Against, errors: Around, name: str) -> dict:
    """Return what was said of a pair; `right`: the difference alone is named, or nothing where there is none."""
    told = found.as_json()
    said = {e["name"]: e["confidence"] for e in told["effects"]}
    sets = [set(group) for group in told["ambiguous"]] + [{n} for n in said]
    right = not said if not name else any(name in group for group in sets)
    return {
        "right": right,
        "said": said,
        "sets": told["ambiguous"],
        "verdict": told["verdict"],
        "reason": told["reason"],
        "simulator": told["against"]["verdict"],
        "simulator_has": list(told["against"]["effects"]),
        "errors": errors.as_json(),
        "over_floor": [
            errors.after.xy_m / errors.floor.xy_m,
            errors.after.theta_rad / errors.floor.theta_rad,
        ],
    }


def table(rows: list[dict]) -> str:
    """Return the rows as a Markdown table."""
    lines = [
        "| simulator | the real robot has more | said | simulator alone: held-out | with what it lacks "
        "| the real robot's own model | noise |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        said = ", ".join(f"{n} {c:.2f}" for n, c in row["said"].items()) or row["verdict"]
        cells = [
            f"{1e3 * row['errors'][k]['xy_m']:.1f} mm, {np.rad2deg(row['errors'][k]['theta_rad']):.2f} deg"
            for k in ("before", "after", "perfect", "floor")
        ]
        lines.append(f"| {row['engine']} | {row['pair']} | {said} | {' | '.join(cells)} |")
    right = sum(row["right"] for row in rows)
    return "\n".join(
        [*lines, "", f"right: {right} of {len(rows)}", *map(floors, ("after", "perfect"), (rows, rows))]
    )


def floors(kind: str, rows: list[dict]) -> str:
    """Return of how many pairs the held-out errors lie within the bar of the noise's floor, and the shares."""
    said = []
    for key in ("xy_m", "theta_rad"):
        shares = [row["errors"][kind][key] / row["errors"]["floor"][key] for row in rows]
        near = sum(share <= BAR for share in shares)
        said.append(f"{key} {near} of {len(rows)} ({min(shares):.2f} to {max(shares):.2f})")
    return f"{kind}: within {BAR} of the floor: {', '.join(said)}"


def main() -> int:
    """Ask the pairs, one after the other."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--engine", choices=("mujoco", "pybullet"), default="mujoco")
    parser.add_argument("--pairs", default=",".join(PAIRS))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("out/against_simulators.jsonl"))
    given = parser.parse_args()
    given.out.parent.mkdir(parents=True, exist_ok=True)
    rows = kept_rows(given.out)
    there = {(row["engine"], row["pair"], row["seed"]) for row in rows}
    for pair in given.pairs.split(","):
        if (given.engine, pair, given.seed) in there:
            continue
        rows.append(asked(given.engine, pair, given.seed))
        with given.out.open("a") as file:
            file.write(json.dumps(rows[-1]) + "\n")
        print(json.dumps(rows[-1]), file=sys.stderr)
    print(table(rows))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
