"""A hundred robots drawn from the fleet, each calibrated from its own pixels, scored by the truth.

    python benchmarks/full_calibration.py [--robots 100] [--first 0] [--jobs 2]

Results are kept in out/benchmarks/, so that an interrupted call goes on; `--again` forgets them. The bars: at
least 97 of 100 finish; deviation over 2 m, all finished at most 0.10 m, median at most 0.02 m; camera error
over the whole image, median at most 0.6 px.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Mapping
from typing import Any

import fleet_runs
import numpy as np

NAME = "full_calibration"
FINISH_SHARE, LARGEST_DEVIATION, MEDIAN_DEVIATION, MEDIAN_CAMERA = 0.97, 0.10, 0.02, 0.6


def tell(row: Mapping[str, Any]) -> None:
    """Print one robot's figures as soon as they are known."""
    camera, wheels, lane = (row[name] or {} for name in ("camera", "wheels", "in_lane"))
    print(
        f"seed {row['seed']:4d}  camera {camera.get('true_px', np.nan):5.2f} px"
        f"  k {wheels.get('wheel_ratio', np.nan):.4f} (true {wheels.get('true_wheel_ratio', np.nan):.4f})"
        f"  deviation {100 * (wheels.get('deviation_2m_m') or np.nan):6.1f} cm"
        f"  lane {100 * (lane.get('deviation_after_m') or np.nan):6.1f} cm{' applied' if lane.get('applied') else ''}"
        f"  {row['seconds']['wall']:5.1f} s  {fleet_runs.ended(row)}",
        flush=True,
    )


def _spread(name: str, values: list[float], unit: str) -> str:
    """Return median, 90th percentile and largest of a figure as a line."""
    p50, p90, largest = np.percentile(np.abs(values), [50, 90, 100])
    return f"{name:44} median {p50:.3f}  90 % {p90:.3f}  largest {largest:.3f} {unit}"


def report(rows: list[dict[str, Any]]) -> bool:
    """Print the figures of all robots and return whether every bar is met."""
    done = [row for row in rows if row["outcome"] == "done"]
    print(f"\n{len(done)} of {len(rows)} finish; the others: {dict(Counter(map(fleet_runs.ended, rows)))}")
    if not done:
        return False
    camera = [row["camera"]["true_px"] for row in done]
    wheels = [row["wheels"]["deviation_2m_m"] for row in done]
    lane = [row["in_lane"]["deviation_after_m"] for row in done]
    error = [row["wheels"]["wheel_ratio"] - row["wheels"]["true_wheel_ratio"] for row in done]
    print(_spread("deviation over 2 m after the wheel iteration", wheels, "m"))
    print(_spread("deviation over 2 m at the end of the run", lane, "m"))
    print(_spread("error of the wheel ratio", error, ""))
    print(_spread("camera error over the whole image", camera, "px"))
    print(_spread("robot time", [row["seconds"]["simulated"] for row in done], "s"))
    print(_spread("wall time", [row["seconds"]["wall"] for row in done], "s"))
    bars = {
        "at least 97 % finish": len(done) >= FINISH_SHARE * len(rows),
        "all deviations <= 0.10 m": max(np.abs([*wheels, *lane])) <= LARGEST_DEVIATION,
        "median deviation <= 0.02 m": np.median(np.abs(wheels)) <= MEDIAN_DEVIATION,
        "median camera error <= 0.6 px": np.median(camera) <= MEDIAN_CAMERA,
    }
    for bar, is_met in bars.items():
        print(f"{'met ' if is_met else 'MISSED'}  {bar}")
    return all(bars.values())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", type=int, default=100)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--again", action="store_true", help="forget kept results")
    options = parser.parse_args()
    if options.again:
        (fleet_runs.OUT / f"{NAME}.jsonl").unlink(missing_ok=True)
    tasks: list[fleet_runs.Task] = [
        ("", seed, {}) for seed in range(options.first, options.first + options.robots)
    ]
    return 0 if report(fleet_runs.run_all(NAME, NAME, tasks, options.jobs, tell)) else 1


if __name__ == "__main__":
    sys.exit(main())
