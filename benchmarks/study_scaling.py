"""Two workers against one: the same robots run with one worker and with two, by turns, in fresh directories.

    python benchmarks/study_scaling.py [--robots 4] [--turns 2]

The bar: two workers do at least 1.8 times as many robots an hour. On a machine that others use, too, look at the
processor time per robot as well: what two workers lose to each other shows there, whatever share they get.
"""

from __future__ import annotations

import argparse
import json
import os
import tempfile
from pathlib import Path
from statistics import mean

from fsm_calib.report.study_files import costs_in
from fsm_calib.study.backends import Crew
from fsm_calib.study.fleet import CommandCost, run_fleet
from fsm_calib.study.models import Study
from fsm_calib.study.store import result_of_row

BAR = 1.8


def small_study(robots: int) -> Study:
    scenario = {"plan": ["orientation", "wheels"], "robot": {"known": {"camera": True}}}
    return Study.model_validate(
        {"name": "scaling", "seed": 29, "robots": robots, "parts": ["test_2"], "scenario": scenario}
    )


def run(robots: int, jobs: int) -> tuple[CommandCost, float, list[str]]:
    """Return the command's cost, the mean processor time of a robot [s], and the results as text."""
    with tempfile.TemporaryDirectory() as folder:
        store = run_fleet(small_study(robots), Path(folder), Crew(jobs=jobs))
        cpu = mean(row["cost"]["test_2"]["cpu"] for row in store.rows.values())
        rows = sorted(json.dumps(result_of_row(row), sort_keys=True) for row in store.rows.values())
        return costs_in(Path(folder))[0], cpu, rows


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robots", type=int, default=4)
    parser.add_argument("--turns", type=int, default=2)
    arguments = parser.parse_args()
    pace: dict[int, list[float]] = {1: [], 2: []}
    seen = set()
    for _ in range(arguments.turns):
        for jobs in (1, 2):
            cost, cpu, rows = run(arguments.robots, jobs)
            pace[jobs].append(cost.robots_per_hour)
            seen.add("\n".join(rows))
            load = os.getloadavg()[0]
            print(
                f"{jobs} worker(s): {cost.robots_per_hour:5.0f} robots/h, overhead {100 * cost.overhead:4.1f} %, "
                f"{cpu:5.2f} s of processor a robot, load {load:.1f}",
                flush=True,
            )
    ratio = mean(pace[2]) / mean(pace[1])
    print(f"two workers against one: {ratio:.2f} x (bar {BAR} x); results equal: {len(seen) == 1}")


if __name__ == "__main__":
    main()
