"""Robots calibrated through ROS 1 or DTPS in lockstep: late and lost frames, late commands, PWM numbers, no truth.

    python benchmarks/served_robots.py --robots 20                           camera 80 +- 10 ms, commands 5 +- 10 ms
    python benchmarks/served_robots.py --robots 20 --camera 0.15 --camera-jitter 0.05 --command 0.05
    python benchmarks/served_robots.py --robots 2 --dtps                     ente's driver: nothing below a command of 0.2

The master is the project's own; `--master http://127.0.0.1:11311/` takes a running roscore.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from served_robot import served, served_dtps

from fsm_calib.errors import DataError
from fsm_calib.perception.prediction import projection_difference
from fsm_calib.robots.ros1.master import Master
from fsm_calib.runner.run import run_scenario
from fsm_calib.scenario.load import load_scenario
from fsm_calib.types import STOP
from fsm_calib.world2d.deviation import straight_deviation

SCENARIO = Path(__file__).resolve().parents[1] / "scenarios" / "full_calibration.yaml"


ENTE = {"dead_zone": 0.2}
"""What ente's driver does otherwise than daffy's."""


def run_one(seed: int, master: str | None, settings: dict[str, float]) -> dict:
    """Return the row of one robot: behind a ROS master, or without one behind a DTPS switchboard."""
    scenario = load_scenario(SCENARIO).model_copy(update={"seed": seed})
    output = scenario.output.model_copy(update={"report": False, "recording": False, "frames": 0})
    scenario, began = scenario.model_copy(update={"output": output}), time.perf_counter()
    serving = (
        served_dtps(scenario, **settings, **ENTE) if master is None else served(scenario, master, **settings)
    )
    with tempfile.TemporaryDirectory() as folder, serving as (node, client):
        finished = run_scenario(client, Path(folder))
        notebook, truth = finished.session.run.bench.notebook, node.station.robot.world.truth
        row = {
            "seed": seed,
            "outcome": finished.result["outcome"],
            "why": finished.result["failure"] or finished.result.get("lost") or {},
            "seconds": time.perf_counter() - began,
            "at_rest": node.station.last_received == STOP,
        }
        if notebook.camera is not None and notebook.figures is not None:
            row["px"] = projection_difference(notebook.camera, truth.camera).rms
        if notebook.runs:
            try:
                row["deviation"] = straight_deviation(truth.parameters, notebook.wheel_ratio)
            except DataError:
                row["deviation"] = float("nan")
    return row


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robots", type=int, default=20)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--camera", type=float, default=0.08)
    parser.add_argument("--camera-jitter", type=float, default=0.01)
    parser.add_argument("--command", type=float, default=0.01, help="jitter of the commands [s]")
    parser.add_argument("--master", default="")
    parser.add_argument("--dtps", action="store_true", help="a switchboard in place of the master")
    given = parser.parse_args()
    settings = {
        "camera_latency": given.camera,
        "camera_jitter": given.camera_jitter,
        "command_jitter": given.command,
        "dropped": 0.1,
        "late": 0.05,
    }
    master = None if given.dtps else given.master or Master().url
    rows = []
    for seed in range(given.first, given.first + given.robots):
        row = run_one(seed, master, settings)
        rows.append(row)
        print(
            f"seed {seed:3d}  {row['outcome']:8s} {row['why'].get('name', ''):22s} camera {row.get('px', np.nan):5.2f} px"
            f"  deviation {100 * row.get('deviation', np.nan):6.1f} cm  wheels {'at zero' if row['at_rest'] else 'TURN'}"
            f"  {row['seconds']:5.0f} s",
            flush=True,
        )
    done = [row for row in rows if row["outcome"] == "done"]
    ways = [abs(row["deviation"]) for row in done]
    print(f"done {len(done)} of {len(rows)}; camera median {np.median([row['px'] for row in done]):.2f} px")
    print(f"after 2 m: median {100 * np.median(ways):.1f} cm, largest {100 * max(ways):.1f} cm")


if __name__ == "__main__":
    main()
