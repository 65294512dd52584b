"""A worn robot passes the marked lane section once: is k back, and is it left alone when nothing has worn?

    python benchmarks/in_lane.py [--robots 20] [--drift 0.04 -0.04 0.0] [--jobs 2]

The scenario is in_lane_refinement with other seeds and drifts: each robot of the fleet begins in the lane with what a
calibration leaves (camera 0.15 px, tilt 0.1 deg, yaw 0.5 deg, k 0.1 %), its true wheel ratio has drifted since.
Results are kept in out/benchmarks/. The bars: deviation over 2 m back to 0.05 m (median) after a drift of 4 %; without
drift no new value is applied to any robot.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from typing import Any

import fleet_runs
import numpy as np

NAME = "in_lane_refinement"
MEDIAN_DEVIATION = 0.05


def tell(row: Mapping[str, Any]) -> None:
    """Print one pass as soon as it is known."""
    lane = row["in_lane"] or {}
    print(
        f"drift {row['label']:>6}  seed {row['seed']:3d}  deviation {100 * lane.get('deviation_before_m', np.nan):6.1f}"
        f" -> {100 * lane.get('deviation_after_m', np.nan):6.1f} cm  {'applied' if lane.get('applied') else 'kept'}"
        f"  {fleet_runs.ended(row)}",
        flush=True,
    )


def report(label: str, rows: list[dict[str, Any]]) -> bool:
    """Print the figures of one drift and return whether its bar is met."""
    done = [row["in_lane"] for row in rows if row["outcome"] == "done"]
    before, after = (np.abs([lane[f"deviation_{when}_m"] for lane in done]) for when in ("before", "after"))
    applied = sum(lane["applied"] for lane in done)
    print(
        f"{label:>6}  {len(done):3d}/{len(rows)}  {applied:3d}      {np.median(before):.3f}"
        f"              {np.median(after):.3f}   {after.max():.3f}",
        flush=True,
    )
    if float(label) == 0.0:
        return applied == 0 and len(done) == len(rows)
    return float(np.median(after)) <= MEDIAN_DEVIATION


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", type=int, default=20)
    parser.add_argument("--first", type=int, default=100)
    parser.add_argument("--drift", type=float, nargs="*", default=[0.04, -0.04, 0.0])
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.robots)
    tasks: list[fleet_runs.Task] = [
        (f"{drift:g}", seed, {"robot": {"known": {"ratio_drift": drift}}})
        for drift in options.drift
        for seed in seeds
    ]
    rows = fleet_runs.run_all("in_lane", NAME, tasks, options.jobs, tell)
    print("\n drift  finished  applied  |deviation| before: median  after: median  largest [m]")
    labels = dict.fromkeys(row["label"] for row in rows)
    met = [report(label, [row for row in rows if row["label"] == label]) for label in labels]
    return 0 if all(met) else 1


if __name__ == "__main__":
    sys.exit(main())
