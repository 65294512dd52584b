"""Forty robots in one call of `fsm-calib fleet`, three of them worn: who is on top, and does a killed call go on?

    python benchmarks/fleet_forty.py --out DIR [--robots 40] [--jobs 2] [--kills 2] [--seed 0]

Robots of this project's own world (`world2d.fleet` draws their wheels and axle) drive 60 s each and leave a ROS 1 bag; a
tyre with a flat that makes its wheel eccentric, a motor that fades as it warms up and a gear with play are worn. The one
command is killed with SIGKILL, its workers with it, after robots that are drawn, and given again until it ends. Printed:
which robots each kill left on disk, whether any was found out twice, the first rows of the page, times.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from fsm_calib.recording.channels import CommandTrack, PoseTrack
from fsm_calib.recording.recording import Recording, RobotFacts
from fsm_calib.recording.writers import write_bag
from fsm_calib.world2d.observation import predict
from fsm_calib.world2d.parameters import parameters
from fsm_calib.world2d.rollout import Drive

SECONDS, RATE = 60.0, 20.0  # s, Hz
NOISE = (0.0015, 0.0015, 0.005)  # m, m, rad of a pose
NOMINAL = {"wheel_radius": 0.0318, "axle_length": 0.1, "max_wheel_rate": 20.0}
SPREAD = 0.04  # of the motors' gains and of the axle, one standard deviation
WORN = {
    "wheel_eccentricity": {"wheel_eccentricity.left": 0.06, "wheel_eccentricity.phase_left": 1.0},
    "motor_warmup": {"motor_warmup.change_left": -0.15, "motor_warmup.change_right": -0.02},
    "gear_backlash": {"gear_backlash.gap": 0.25},
}
"""What is worn, and how much."""
POLL = 0.05  # s


def commands(rng: np.random.Generator) -> Drive:
    """Return straights, spins and arcs at many levels, both ways, with rests."""
    at, rows = 0.5, []
    while at < SECONDS - 2.0:
        u, hold = rng.uniform(0.15, 0.6), rng.uniform(0.6, 1.6)
        pair = [(u, u), (-u, -u), (u, -u), (-u, u), (u, 0.5 * u), (0.5 * u, u)][rng.integers(6)]
        rows += [(at, *pair), (at + hold, 0.0, 0.0)]
        at += hold + 0.4
    return Drive(*np.array(rows).T)


def make(folder: Path, count: int, seed: int) -> dict[str, str]:
    """Write one bag a robot below `folder`; return what the worn ones have."""
    rng = np.random.default_rng(seed)
    worn = dict(zip(rng.choice(count, len(WORN), replace=False).tolist(), WORN, strict=True))
    folder.mkdir(parents=True, exist_ok=True)
    for k in range(count):
        gains, axle = 0.636 * (1.0 + SPREAD * rng.normal(size=2)), 0.1 * (1.0 + 0.5 * SPREAD * rng.normal())
        values = {"gain_left": gains[0], "gain_right": gains[1], "axle_length": axle} | WORN.get(
            worn.get(k, ""), {}
        )
        drive, stamps = commands(rng), np.arange(0.0, SECONDS, 1.0 / RATE)
        seen = predict(parameters(values), drive, stamps, (0.0, 0.0, rng.uniform(-3.0, 3.0))).poses
        poses = seen + rng.normal(size=seen.shape) * NOISE
        path = folder / f"duck{k:02d}.bag"
        if not path.exists():
            facts = RobotFacts(name=path.stem, **NOMINAL)
            command = CommandTrack(drive.time, drive.left, drive.right)
            write_bag(Recording(robot=facts, command=command, pose=PoseTrack(stamps, *poses.T)), path)
    return {f"duck{k:02d}": name for k, name in worn.items()}


def rows(out: Path) -> dict[str, dict]:
    """Return the rows that are on disk, by robot."""
    return {path.stem: json.loads(path.read_text()) for path in sorted((out / "robots").glob("*.json"))}


def command(bags: Path, out: Path, jobs: int) -> list[str]:
    """Return the one command."""
    places = [str(path) for path in sorted(bags.glob("*.bag"))]
    entry = "from fsm_calib.cli import main; main()"
    return [
        sys.executable,
        "-c",
        entry,
        "fleet",
        *places,
        "--diagnose",
        "--jobs",
        str(jobs),
        "--out",
        str(out),
    ]


def killed(call: list[str], out: Path, after: int) -> int:
    """Start the command, kill it and its workers once `after` robots are on disk; return how many are then."""
    with subprocess.Popen(
        call, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL, start_new_session=True
    ) as process:
        while process.poll() is None and len(list((out / "robots").glob("*.json"))) < after:
            time.sleep(POLL)
        os.killpg(process.pid, signal.SIGKILL)
    return len(rows(out))


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--robots", type=int, default=40)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--kills", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    worn = make(options.out / "bags", options.robots, options.seed)
    out = options.out / "fleet"
    call = command(options.out / "bags", out, options.jobs)
    rng, began, processes = np.random.default_rng(options.seed), time.perf_counter(), {}
    for after in sorted(rng.integers(3, options.robots - 3, options.kills).tolist()):
        print(f"killed with {killed(call, out, after)} of {options.robots} robots on disk", flush=True)
        found = {name: (row["process"], row["seconds"]) for name, row in rows(out).items()}
        again = [name for name in processes if processes[name] != found.get(name)]
        print(f"  found out twice so far: {', '.join(again) or 'none'}", flush=True)
        processes = found
    ended = subprocess.run(call, capture_output=True, text=True, check=False)
    found = rows(out)
    again = [n for n in processes if processes[n] != (found[n]["process"], found[n]["seconds"])]
    lines = [line for line in ended.stdout.splitlines() if line.startswith("duck")]
    print(
        f"ended with exit code {ended.returncode}, {len(found)} robots, found out twice: {', '.join(again) or 'none'}"
    )
    for place, line in enumerate(lines[:6], 1):
        name = line.split(":")[0]
        verdict = found[name]["diagnosis"]
        names = ", ".join(f"{e['name']} {e['confidence']:.2f}" for e in verdict["effects"])
        print(f"  {place}. {line} | {verdict['verdict']}: {names or '-'} | worn: {worn.get(name, '-')}")
    seconds = [row["seconds"] for row in found.values()]
    print(
        f"{np.median(seconds):.1f} s a robot in the median, {time.perf_counter() - began:.0f} s in all, {options.jobs} jobs"
    )


if __name__ == "__main__":
    main()
