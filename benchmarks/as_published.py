"""The method as published against the corrected one, on the same robots, and each published behaviour by itself.

    python benchmarks/as_published.py [--robots 20] [--jobs 2] [--variant NAME ...]

`corrected` and `as published` run scan, orientation and wheels; each single behaviour of the wheels is switched on in
an otherwise corrected run of orientation and wheels with a known camera (`corrected, camera known` is its reference);
each of the scan's in a run of the scan alone. Results are kept in out/benchmarks/.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Mapping
from typing import Any

import fleet_runs
import numpy as np

WHEELS = {"plan": ["orientation", "wheels"], "robot": {"known": {"camera": True}}}
SCAN = {"plan": ["scan"]}
VARIANTS: dict[str, dict[str, Any]] = {
    "corrected": {"published": []},
    "as published": {},
    "corrected, camera known": WHEELS | {"published": []},
    "equation_3": WHEELS | {"published": ["equation_3"]},
    "quiet_threshold": WHEELS | {"published": ["quiet_threshold"]},
    "camera_yaw": WHEELS | {"published": ["camera_yaw"]},
    "last_marker": WHEELS | {"published": ["last_marker"]},
    "camera_yaw_threshold": WHEELS | {"published": ["camera_yaw_threshold"]},
    "single_miss_flip": SCAN | {"published": ["single_miss_flip"]},
    "late_bound_check": SCAN | {"published": ["late_bound_check"]},
}


def tell(row: Mapping[str, Any]) -> None:
    """Print one run as soon as it is known."""
    wheels = row["wheels"] or {}
    error = wheels.get("wheel_ratio", np.nan) - wheels.get("true_wheel_ratio", np.nan)
    deviation = wheels.get("deviation_2m_m")
    print(
        f"{row['label']:24} seed {row['seed']:3d}  k error {error:+.4f}"
        f"  deviation {np.nan if deviation is None else 100 * deviation:6.1f} cm  {fleet_runs.ended(row)}",
        flush=True,
    )


def summary(label: str, rows: list[dict[str, Any]]) -> str:
    """Return a variant's line of the table in docs/method.md."""
    done = [row for row in rows if row["outcome"] == "done"]
    found = [row["wheels"] for row in done if row["wheels"]]
    failed = Counter(row["failure"]["name"] for row in rows if row["failure"])
    errors = [abs(wheels["wheel_ratio"] - wheels["true_wheel_ratio"]) for wheels in found]
    ways = [abs(wheels["deviation_2m_m"]) for wheels in found if wheels["deviation_2m_m"] is not None]
    pixels = [row["camera"]["true_px"] for row in done if row["camera"]]
    columns = (
        _two(errors, "{:.4f}"),
        _two(ways, "{:.2f} m"),
        "–" if not pixels else f"{np.median(pixels):.2f} px",
        ", ".join(f"{name} {count}" for name, count in failed.most_common()) or "–",
    )
    return f"| {label} | {len(done)}/{len(rows)} | " + " | ".join(columns) + " |"


def _two(values: list[float], form: str) -> str:
    """Return median and largest of some values."""
    return f"{form.format(np.median(values))} / {form.format(max(values))}" if values else "–"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--variant", nargs="*", choices=list(VARIANTS), default=list(VARIANTS))
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.robots)
    tasks: list[fleet_runs.Task] = [
        (name, seed, VARIANTS[name]) for name in options.variant for seed in seeds
    ]
    rows = fleet_runs.run_all("as_published", "as_published", tasks, options.jobs, tell)
    print("\n| variant | finished | k error: median / largest | deviation over 2 m | camera error | failed |")
    print("|---|---|---|---|---|---|")
    for name in options.variant:
        print(summary(name, [row for row in rows if row["label"] == name]))


if __name__ == "__main__":
    main()
