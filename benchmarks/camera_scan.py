"""How good is the camera that a scan gives? Robots of the fleet, rendered pixels, error against truth.

    python benchmarks/camera_scan.py --runs 100      (resumable; --table prints what is there, --plot FILE draws it)

Each run draws a robot (lens, pitch, height, focus), lets it turn on one wheel, 3 deg a step, 75 deg to each side, in
an area with boards, renders every stop, and solves. Beside it 30 hand-held views of one board, 0.18 to 0.6 m away,
tilted up to 45 deg, are rendered and solved by the same code. The error is "al": projections of the same ray over
the whole image, best rotation removed.

Predicted against true error is compared where the prediction is used: after the first 6, 8, 12, ... views of every
scan and of every set by hand, as the stop rule sees them, and for the final cameras.
"""

import argparse
import json
import math
import time
from pathlib import Path

import cv2
import numpy as np
from camera_runs import BOARD, LAYOUTS, SIZE, hand_held, scan

from fsm_calib.perception.information import StopRule, begin_scan, is_enough, solve_scan, weigh_view
from fsm_calib.perception.intrinsics import calibrate
from fsm_calib.perception.prediction import projection_difference
from fsm_calib.perception.static_boards import calibrate_static, frames_of
from fsm_calib.types import BoardView
from fsm_calib.world2d.fleet import RobotSpec, draw_robot

COUNTS = (6, 8, 12, 16, 23, 32, 45, 64, 90)  # views after which prediction and truth are compared
HALF_PIXEL = StopRule(predicted_px=0.5, views_per_board=8, views=15, smallest_gain=0.005)
WITHIN = 2.5  # the prediction's bar: true error at most this many times the predicted one


def informed(views: list[BoardView], boards: int) -> tuple[list[BoardView], bool]:
    """Return the views that a scan keeps until it predicts 0.5 px twice in a row, and whether it came to that."""
    progress, kept, precise = begin_scan(SIZE, boards), [], 0
    for view in views:
        weighed = weigh_view(view, BOARD, progress, HALF_PIXEL)
        if not weighed.is_wanted:
            continue
        kept.append(view)
        progress = weighed.progress
        if len(kept) % 5 == 0:
            progress = solve_scan(kept, BOARD, progress)
            precise = precise + 1 if is_enough(progress, HALF_PIXEL) else 0
            if precise == 2:
                return kept, True
    return kept, False


def figures(views: list[BoardView], robot: RobotSpec, *, static: bool) -> dict[str, object]:
    """Return what solving the views gives against the truth."""
    begun = time.perf_counter()
    free = calibrate(views, BOARD, SIZE, is_duckiebot=True)
    row: dict[str, object] = {
        "views": free.views_used,
        "per_board": list(free.views_per_board),
        "dropped": len(free.views_dropped),
        "coefficients": 4 if free.camera.distortion[4] == 0.0 else 5,
        "model": free.camera.model,
        "noise_px": free.noise_px,
        "rms_px": free.rms_px,
        "free_px": projection_difference(robot.camera, free.camera).rms,
        "free_predicted_px": free.predicted_px,
        "refused": free.reason,
    }
    if static:
        found = calibrate_static(views, frames_of(views), BOARD, free)
        row |= {
            "static_px": projection_difference(robot.camera, found.calibration.camera).rms,
            "static_predicted_px": found.calibration.predicted_px,
            "is_static": found.is_static,
            "sentence": found.sentence,
            "pitch_error_deg": math.degrees(found.pitch - robot.mount.pitch),
            "roll_error_deg": math.degrees(found.roll - robot.mount.roll),
            "height_error_m": found.height - robot.mount.height,
        }
    return row | {"solve_s": time.perf_counter() - begun}


def along(views: list[BoardView], boards: int, robot: RobotSpec) -> list[tuple[int, float, float]]:
    """Return (views, predicted px, true px) after the first so many views, each solved from the last camera."""
    progress, found = begin_scan(SIZE, boards), []
    for count in (number for number in COUNTS if number <= len(views)):
        progress = solve_scan(views[:count], BOARD, progress)
        true = projection_difference(robot.camera, progress.camera).rms
        found.append((count, progress.predicted_px, true))
    return found


def run(seed: int, layout: str) -> dict[str, object]:
    """Return the figures of one robot: its whole scan, the scan that stops by information, 30 hand-held views."""
    rng = np.random.default_rng([seed, 5])
    robot = draw_robot(rng, f"robot{seed}")
    begun = time.perf_counter()
    views = scan(robot, LAYOUTS[layout], rng)
    scanned = time.perf_counter()
    kept, stopped = informed(views, len(LAYOUTS[layout]))
    chosen = time.perf_counter()
    held = hand_held(robot, 30, rng)
    return {
        "seed": seed,
        "layout": layout,
        "scan": figures(views, robot, static=True),
        "stopped": figures(kept, robot, static=True) | {"reached": stopped},
        "hand": figures(held, robot, static=False),
        "along_scan": along(views, len(LAYOUTS[layout]), robot),
        "along_hand": along(held, 1, robot),
        "seconds": [scanned - begun, chosen - scanned, time.perf_counter() - chosen],
    }


def table(rows: list[dict]) -> str:
    """Return the figures of all runs as text."""
    lines = [f"{len(rows)} runs, layout {rows[0]['layout']}: error against truth over the image, px"]
    lines.append(f"{'':34} median    95 %     max  ahead of hand  log-corr  within 2.5 x predicted")
    hand = np.array([row["hand"]["free_px"] for row in rows])
    series = (
        ("whole scan, static boards", "scan", "static"),
        ("whole scan, free boards", "scan", "free"),
        ("stopped by information, static", "stopped", "static"),
        ("stopped by information, free", "stopped", "free"),
        ("30 hand-held views", "hand", "free"),
    )
    for label, part, kind in series:
        true = np.array([row[part][f"{kind}_px"] for row in rows])
        predicted = np.array([row[part][f"{kind}_predicted_px"] for row in rows])
        correlation = np.corrcoef(np.log(true), np.log(predicted))[0, 1] if len(rows) > 2 else math.nan
        within = np.mean(true <= WITHIN * predicted)
        lines.append(
            f"{label:34} {np.median(true):6.3f}  {np.percentile(true, 95):6.3f}  {true.max():6.3f}"
            f"  {np.mean(true < hand):8.0%}       {correlation:5.2f}     {within:.0%}"
        )
    lines += [prediction_line(rows, part) for part in ("along_scan", "along_hand")]
    views = [np.median([row[part]["views"] for row in rows]) for part in ("scan", "stopped")]
    noise = np.median([row["scan"]["noise_px"] for row in rows])
    kept = np.mean([row["scan"]["is_static"] for row in rows])
    lines.append(
        f"views: {views[0]:.0f} whole, {views[1]:.0f} stopped; corner noise {noise:.3f} px; static in {kept:.0%}"
    )
    for name in ("pitch_error_deg", "roll_error_deg", "height_error_m"):
        values = np.abs([row["scan"][name] for row in rows])
        if np.isfinite(values).any():
            lines.append(
                f"|{name}| median {np.nanmedian(values):.4f}, 95 % {np.nanpercentile(values, 95):.4f}"
            )
    return "\n".join(lines)


def prediction_line(rows: list[dict], part: str) -> str:
    """Return how prediction and truth agree over all counts of views."""
    _, predicted, true = np.array([point for row in rows for point in row[part]]).T
    correlation = np.corrcoef(np.log(true), np.log(predicted))[0, 1]
    within = np.mean(true <= WITHIN * predicted)
    where = "scans" if part == "along_scan" else "sets by hand"
    return (
        f"predicted and true after the first {COUNTS[0]} to {COUNTS[-1]} views of all {where} ({len(true)} cameras, "
        f"{true.min():.2f} to {true.max():.1f} px): log-correlation {correlation:.2f}, within {WITHIN} x {within:.0%}"
    )


def plot(rows: list[dict], path: Path) -> None:
    """Draw true against predicted error."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(figsize=(6.0, 5.0), layout="constrained")
    for part, label, colour in (
        ("along_scan", "scans", "#1f77b4"),
        ("along_hand", "sets by hand", "#ff7f0e"),
    ):
        _, predicted, true = np.array([point for row in rows for point in row[part]]).T
        axes.loglog(predicted, true, ".", markersize=4, alpha=0.5, color=colour, label=label)
    ends = np.array(axes.get_xlim())
    axes.loglog(ends, ends, color="black", linewidth=0.8, label="true = predicted")
    axes.loglog(
        ends, WITHIN * ends, color="black", linewidth=0.8, linestyle="--", label=f"{WITHIN} x predicted"
    )
    axes.set(xlabel="predicted error over the image [px]", ylabel="true error over the image [px]", xlim=ends)
    axes.legend()
    figure.savefig(path, dpi=110)


def main() -> None:
    """Run what is missing and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=100)
    parser.add_argument("--layout", choices=sorted(LAYOUTS), default="mixed3")
    parser.add_argument("--out", type=Path, default=Path("out/camera_scan.jsonl"))
    parser.add_argument("--table", action="store_true", help="print what is there, run nothing")
    parser.add_argument("--plot", type=Path, help="draw true against predicted error into this file")
    options = parser.parse_args()
    cv2.setNumThreads(1)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    lines = options.out.read_text().splitlines() if options.out.exists() else []
    rows = [row for row in map(json.loads, lines) if row["layout"] == options.layout]
    done = {row["seed"] for row in rows}
    for seed in range(0 if options.table else options.runs):
        if seed not in done:
            rows.append(run(seed, options.layout))
            with options.out.open("a") as file:
                file.write(json.dumps(rows[-1]) + "\n")
    print(table(rows))
    if options.plot is not None:
        plot(rows, options.plot)


if __name__ == "__main__":
    main()
