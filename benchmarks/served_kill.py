"""Kills calibrations of a served robot with SIGKILL at random events, resumes them, and says how good they end.

    python benchmarks/served_kill.py [--robots 10] [--first 1] [--out out/served_kill.jsonl]

Each robot of the fleet is served through ROS 1 in lockstep, with the delays and losses of `served_robots.py`; the program
is a process of its own, `fsm-calib run`, killed when its journal reaches a random event, and then `fsm-calib run --resume`.
In between the robot is put back where the phase began, as docs/robot.md asks of its owner (`--left`: it stays where it
stood). Robots are kept in ``--out`` as they end, and a second call goes on where the first one ended.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from kept_rows import kept_rows

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from ros_rig import until
from served_robot import served

from fsm_calib.perception.prediction import projection_difference
from fsm_calib.robots.ros1.master import Master
from fsm_calib.scenario.load import load_scenario
from fsm_calib.types import STOP, CameraModel
from fsm_calib.world2d.deviation import straight_deviation
from fsm_calib.world2d.robot import World

EVENTS = 250
"""Events of the shortest undisturbed runs: a kill is drawn from as many [1]."""
SCENARIO = """name: killed
seed: {seed}
robot: {{source: fleet, name: duckie, link: {{lockstep: true}}}}
plan: [focus, scan, orientation, wheels, exit, lane]
output: {{report: false, recording: false, bag: none, frames: 0}}
"""
LOSSES = {"camera_latency": 0.08, "camera_jitter": 0.01, "command_jitter": 0.01, "dropped": 0.1, "late": 0.05}
POLL = 0.005
"""Time between two looks at the journal [s]."""
LONGEST = 3600.0
"""Longest a run may take on a loaded machine [s]."""


def command(file: Path, master: str, *options: str) -> list[str]:
    address = master.replace("http", "ros1") + "duckie"
    return [sys.executable, "-m", "fsm_calib.cli", "run", str(file), "--robot", address, "--yes", *options]


def killed(given: list[str], journal: Path, event: int) -> int:
    """Run a command, kill it when its journal has so many events, and return how many it has then."""
    process = subprocess.Popen(given, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while process.poll() is None and events(journal) < event:
        time.sleep(POLL)
    process.kill()
    process.wait()
    return events(journal)


def events(journal: Path) -> int:
    return journal.read_bytes().count(b"\n") if journal.exists() else 0


def put_back(world: World, journal: list[dict], phase: str) -> None:
    """Put the robot where it stood when the phase began."""
    began = next(row["time"] for row in journal if row["phase"] == phase)
    trace = world.truth.trace
    x, y, theta = trace[np.searchsorted(trace[:, 0], began, side="right") - 1, 1:4]
    body = (
        world.truth._motion.body.body
    )  # nobody but an owner's hand may move a robot, and there is none here
    body.position, body.angle = (float(x), float(y)), float(theta)


def robot(seed: int, master: str, is_left: bool) -> dict:
    """Calibrate a served robot in two halves; return how it ended and how good the calibration is."""
    event = int(np.random.default_rng([1, seed]).integers(1, EVENTS))
    with tempfile.TemporaryDirectory() as name:
        file, out = Path(name) / "scenario.yaml", Path(name) / "run"
        file.write_text(SCENARIO.format(seed=seed))
        with served(load_scenario(file), master, **LOSSES) as (node, _):
            at = killed(command(file, master, "--out", str(out)), out / "journal.jsonl", event)
            journal = [json.loads(line) for line in (out / "journal.jsonl").read_text().splitlines()[:at]]
            phase = journal[-1]["phase"]
            until(lambda: node.last_received == STOP, "the wheels stand")
            if phase and not is_left:  # between two phases it stands where the next begins
                put_back(node.robot.world, journal, phase)
            again = subprocess.run(
                command(file, master, "--resume", str(out)), capture_output=True, text=True, timeout=LONGEST
            )
            result, truth = json.loads((out / "result.json").read_text()), node.robot.world.truth
            row = {
                "seed": seed,
                "killed_at": at,
                "phase": phase,
                "outcome": result["outcome"],
                "exit": again.returncode,
            }
            row["why"] = result["failure"] or result.get("lost") or {}
            if result["outcome"] == "done":
                lane = result["in_lane"]["wheel_ratio_after"]
                row["deviation_m"] = straight_deviation(truth.parameters, lane)
                camera = result["camera"]
                found = CameraModel(
                    np.array(camera["matrix"]), np.array(camera["distortion"]), model=camera["model"]
                )
                row["px"] = projection_difference(found, truth.camera).rms
    return row


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robots", type=int, default=10)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("out/served_kill.jsonl"))
    parser.add_argument(
        "--left", action="store_true", help="leave the robot where it stood when it was killed"
    )
    given = parser.parse_args()
    given.out.parent.mkdir(parents=True, exist_ok=True)
    rows = kept_rows(given.out)
    master = Master().url
    for seed in range(given.first, given.first + given.robots):
        if seed in [row["seed"] for row in rows]:
            continue
        rows.append(robot(seed, master, given.left))
        with given.out.open("a") as file:
            file.write(json.dumps(rows[-1]) + "\n")
        print(json.dumps(rows[-1]), flush=True)
    done = [row for row in rows if row["outcome"] == "done"]
    ways = [100 * abs(row["deviation_m"]) for row in done]
    print(f"done {len(done)} of {len(rows)}; camera median {np.median([row['px'] for row in done]):.2f} px")
    print(f"after 2 m: median {np.median(ways):.1f} cm, largest {max(ways):.1f} cm")


if __name__ == "__main__":
    main()
