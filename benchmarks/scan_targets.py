"""What the scan's threshold buys: predicted error asked for against true error, views and time, on robots of the fleet.

    python benchmarks/scan_targets.py [--robots 12] [--targets 0.85 0.35 0.25 sweep_count] [--layout mixed] [--boards 3]

Each robot scans and solves its camera as in a full calibration, once for every target; `sweep_count` is the published
rule. Results are kept in out/benchmarks/, so that an interrupted call goes on.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Any

import fleet_runs
import numpy as np

NAME = "scan_targets"
SWEEPS = "sweep_count"
WITHIN = 2.5  # the prediction's bar: true error at most this many times the expected one


def changes(label: str, layout: str, boards: int) -> dict[str, Any]:
    """Return what a rule changes in the scenario."""
    area = {"plan": ["scan"], "scene": {"boards": {"layout": layout, "count": boards}}}
    if label == SWEEPS:
        return area | {"published": [SWEEPS]}
    return area | {"actions": {"camera": {"target_px": float(label)}}}


def tell(row: Mapping[str, Any]) -> None:
    """Print one scan as soon as it is known."""
    camera = row["camera"] or {}
    print(
        f"seed {row['seed']:3d}  {row['label']:>24}  true {camera.get('true_px', np.nan):.3f} px"
        f"  predicted {camera.get('predicted_px', np.nan):.3f} px  {camera.get('views_used', 0):3d} views"
        f"  {row['seconds']['simulated']:5.1f} s  {fleet_runs.ended(row)}",
        flush=True,
    )


def line(label: str, rows: list[dict[str, Any]]) -> str:
    """Return the line of one rule of the table in docs/camera.md."""
    cameras = [row["camera"] for row in rows if row["camera"] and row["outcome"] == "done"]
    true = [camera["true_px"] for camera in cameras]
    figures = {
        name: np.median([camera[name] for camera in cameras]) for name in ("views_used", "views_refused")
    }
    reached = np.mean([bool(camera["reached"]) for camera in cameras])
    seconds = [row["seconds"]["simulated"] for row in rows]
    within = np.mean([camera["true_px"] <= WITHIN * camera["expected_px"] for camera in cameras])
    promised = np.mean([camera["true_px"] <= camera["predicted_px"] for camera in cameras])
    return (
        f"| {label} | {len(cameras)}/{len(rows)} | {reached:.0%} | {np.median(true):.3f} | "
        f"{np.percentile(true, 95):.3f} | {max(true):.3f} | {promised:.0%} | {within:.0%} | "
        f"{figures['views_used']:.0f} | {figures['views_refused']:.0f} | {np.median(seconds):.0f} | {max(seconds):.0f} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", type=int, default=12)
    parser.add_argument("--targets", nargs="*", default=["0.85", "0.35", "0.25", SWEEPS])
    parser.add_argument("--layout", choices=["mixed", "upright"], default="mixed")
    parser.add_argument("--boards", type=int, default=3)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    labels = options.targets
    tasks: list[fleet_runs.Task] = [
        (label, seed, changes(label, options.layout, options.boards))
        for seed in range(options.robots)
        for label in labels
    ]
    name = f"{NAME}_{options.layout}{options.boards}"
    rows = fleet_runs.run_all(name, "full_calibration", tasks, options.jobs, tell)
    print(
        "\n| target, px | finished | reached | true error, median | 95 % | largest | within predicted | within 2.5 x expected"
        " | views | refused | time, s | longest |"
    )
    print("|" + 12 * "---|")
    for label in labels:
        print(line(label, [row for row in rows if row["label"] == label]))


if __name__ == "__main__":
    main()
