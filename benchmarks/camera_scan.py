"""How good is the camera that a scan gives? Robots of the fleet, rendered pixels, error against truth.

    python benchmarks/camera_scan.py --runs 100                      (resumable; --table prints what is there)
    python benchmarks/camera_scan.py --runs 20 --layout upright2     (into the same file; --plot FILE draws all)

Each run draws a robot (lens, pitch, height, focus), lets it turn on one wheel, 3 deg a step, 75 deg to each side, in
an area with boards, renders every stop, and solves: the whole scan, the scan that ends by the robot's default rule,
and the one that ends at 0.85 px predicted (0.5 px expected). Beside it 30 hand-held views of one board, 0.18 to 0.6 m away,
tilted up to 45 deg, are rendered and solved by the same code. The error is "al": projections of the same ray over
the whole image, best rotation removed.

Predicted against true error is compared where the prediction is used: after the first 6, 8, 12, ... views of every
scan and of every set by hand, as the stop rule sees them and as the final solve does, and for the final cameras.
"""

import argparse
import json
import math
from pathlib import Path

import cv2
import numpy as np
from camera_runs import BOARD, LAYOUTS, SIZE, hand_held, scan

from fsm_calib.actions.judging import stop_rule
from fsm_calib.actions.settings import CameraSettings
from fsm_calib.perception.information import StopRule, begin_scan, is_enough, solve_scan, weigh_view
from fsm_calib.perception.intrinsics import calibrate
from fsm_calib.perception.prediction import projection_difference
from fsm_calib.perception.solve_settings import SolveSettings
from fsm_calib.perception.static_boards import calibrate_static, frames_of
from fsm_calib.types import BoardView
from fsm_calib.world2d.fleet import RobotSpec, draw_robot

COUNTS = (6, 8, 12, 16, 23, 32, 45, 64, 90)  # views after which prediction and truth are compared
RULES = {"stopped": stop_rule(CameraSettings()), "half": StopRule(predicted_px=0.85, smallest_gain=0.005)}
QUICK = SolveSettings(coefficients=(4,), all_but_one_up_to=0, folds=2)  # no choice of a model along the way
WITHIN = 2.5  # the expected error's bar: true error at most this many times the expected one


def informed(views: list[BoardView], boards: int, rule: StopRule) -> tuple[list[BoardView], bool]:
    """Return the views that a scan keeps until it predicts enough twice in a row, and whether it came to that."""
    progress, kept, precise = begin_scan(SIZE, boards), [], 0
    for view in views:
        weighed = weigh_view(view, BOARD, progress, rule)
        if not weighed.is_wanted:
            continue
        kept.append(view)
        progress = weighed.progress
        if len(kept) % 5 == 0:
            progress = solve_scan(kept, BOARD, progress)
            precise = precise + 1 if is_enough(progress, rule) else 0
            if precise == 2:
                return kept, True
    return kept, False


def figures(views: list[BoardView], robot: RobotSpec, *, static: bool) -> dict[str, object]:
    """Return what solving the views gives against the truth."""
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
        "free_expected_px": free.predicted_map.expected,
        "free_predicted_px": free.predicted_px,
        "refused": free.reason,
    }
    if static:
        found = calibrate_static(views, frames_of(views), BOARD, free)
        row |= {
            "static_px": projection_difference(robot.camera, found.calibration.camera).rms,
            "static_expected_px": found.calibration.predicted_map.expected,
            "static_predicted_px": found.calibration.predicted_px,
            "is_static": found.is_static,
            "sentence": found.sentence,
            "pitch_error_deg": math.degrees(found.pitch - robot.mount.pitch),
            "roll_error_deg": math.degrees(found.roll - robot.mount.roll),
            "height_error_m": found.height - robot.mount.height,
        }
    return row


def along(views: list[BoardView], boards: int, robot: RobotSpec) -> list[tuple[int, float, float]]:
    """Return (views, expected px, true px) after the first so many views, each solved from the last camera."""
    progress, found = begin_scan(SIZE, boards), []
    for count in (number for number in COUNTS if number <= len(views)):
        progress = solve_scan(views[:count], BOARD, progress)
        true = projection_difference(robot.camera, progress.camera).rms
        found.append((count, progress.predicted.expected, true))
    return found


def along_static(views: list[BoardView], robot: RobotSpec) -> list[tuple[int, float, float]]:
    """Return (views, expected px, true px) of the static solve of the first so many views, where it is taken."""
    found = []
    for count in (number for number in COUNTS if number <= len(views)):
        first = views[:count]
        free = calibrate(first, BOARD, SIZE, is_duckiebot=True, settings=QUICK)
        static = calibrate_static(first, frames_of(first), BOARD, free, settings=QUICK)
        if static.is_static:
            true = projection_difference(robot.camera, static.calibration.camera).rms
            found.append((count, static.calibration.predicted_map.expected, true))
    return found


def run(seed: int, layout: str) -> dict[str, object]:
    """Return the figures of one robot: its whole scan, the scans that a rule ends, 30 hand-held views."""
    rng = np.random.default_rng([seed, 5])
    robot, boards = draw_robot(rng, f"robot{seed}"), len(LAYOUTS[layout])
    views = scan(robot, LAYOUTS[layout], rng)
    held = hand_held(robot, 30, rng)
    row: dict[str, object] = {
        "seed": seed,
        "layout": layout,
        "scan": figures(views, robot, static=True),
        "hand": figures(held, robot, static=False),
        "along_scan": along(views, boards, robot),
        "along_static": along_static(views, robot),
        "along_hand": along(held, 1, robot),
    }
    for name, rule in RULES.items():
        kept, reached = informed(views, boards, rule)
        row[name] = figures(kept, robot, static=True) | {"reached": reached}
    return row


SERIES = (
    ("whole scan, static boards", "scan", "static"),
    ("whole scan, free boards", "scan", "free"),
    ("default rule, static boards", "stopped", "static"),
    ("default rule, free boards", "stopped", "free"),
    ("0.85 px predicted, static boards", "half", "static"),
    ("0.85 px predicted, free boards", "half", "free"),
    ("30 hand-held views", "hand", "free"),
)
ALONG = (
    ("along_scan", "as the stop rule sees them"),
    ("along_static", "static boards"),
    ("along_hand", "by hand"),
)
FINAL = (
    ("scan", "static", "whole scan, static boards"),
    ("stopped", "static", "default rule, static boards"),
    ("hand", "free", "30 hand-held views"),
)
#: sd of the logarithm of true errors about one prediction [1], measured by camera_prediction_limit.py on that layout
CHANCE_LAYOUT = "mixed3"
CHANCE = {"stopped": 0.51, "hand": 0.46}


def table(rows: list[dict]) -> str:
    """Return the figures of all runs of one layout as text."""
    lines = [f"\n{len(rows)} runs, layout {rows[0]['layout']}: error against truth over the image, px"]
    lines.append(
        f"{'':34} median    95 %     max  ahead of hand  log-corr  within {WITHIN} x expected, within predicted  views"
    )
    hand = np.array([row["hand"]["free_px"] for row in rows])
    for label, part, kind in SERIES:
        expected, true = final(rows, part, kind)
        predicted = np.array([row[part][f"{kind}_predicted_px"] for row in rows])
        views = np.median([row[part]["views"] for row in rows])
        lines.append(
            f"{label:34} {np.median(true):6.3f}  {np.percentile(true, 95):6.3f}  {true.max():6.3f}"
            f"  {np.mean(true < hand):8.0%}       {agreement(expected, true)}     {np.mean(true <= predicted):4.0%}  {views:.0f}"
        )
    lines += [along_line(rows, part, label) for part, label in ALONG]
    for part in ("scan", "stopped"):
        static, free = final(rows, part, "static")[1], final(rows, part, "free")[1]
        ahead, taken = np.mean(static < free), np.mean([row[part]["is_static"] for row in rows])
        lines.append(
            f"{part}: static boards ahead of free ones in {ahead:.0%}, taken in {taken:.0%}; median error of the same "
            f"views {1.0 - np.median(static) / np.median(free):.0%} less, largest {1.0 - static.max() / free.max():.0%}"
        )
    lines.append(f"corner noise {np.median([row['scan']['noise_px'] for row in rows]):.3f} px")
    for name in ("pitch_error_deg", "roll_error_deg", "height_error_m"):
        values = np.abs([row["scan"][name] for row in rows])
        if np.isfinite(values).any():
            lines.append(
                f"|{name}| median {np.nanmedian(values):.4f}, 95 % {np.nanpercentile(values, 95):.4f}"
            )
    return "\n".join(lines)


def final(rows: list[dict], part: str, kind: str) -> tuple[np.ndarray, np.ndarray]:
    """Return expected and true error [px] of the final cameras of one kind."""
    expected = [row[part][f"{kind}_expected_px"] for row in rows]
    return np.array(expected), np.array([row[part][f"{kind}_px"] for row in rows])


def agreement(expected: np.ndarray, true: np.ndarray) -> str:
    """Return the log-correlation and how often the truth is within the bar."""
    correlation = np.corrcoef(np.log(true), np.log(expected))[0, 1] if len(true) > 2 else math.nan
    return f"{correlation:5.2f}     {np.mean(true <= WITHIN * expected):4.0%}"


def along_line(rows: list[dict], part: str, label: str) -> str:
    """Return how the expected error and the truth agree over all counts of views."""
    _, expected, true = np.array([point for row in rows for point in row[part]]).T
    return (
        f"after the first {COUNTS[0]} to {COUNTS[-1]} views, {label}: {len(true)} cameras, {true.min():.2f} to "
        f"{true.max():.1f} px, {agreement(expected, true)}"
    )


def together(rows: list[dict]) -> str:
    """Return how prediction and truth agree over every camera on these runs, and over the final cameras alone."""
    points = np.array([point for row in rows for part, _ in ALONG for point in row[part]])
    ways = ", ".join(label for _, label in ALONG)
    lines = [
        f"\nover every camera on those runs, the first {COUNTS[0]} to {COUNTS[-1]} views solved each way ({ways}):",
        f"    {in_words(points[:, 1], points[:, 2])}",
        "final cameras alone, which stopped at about one prediction:",
    ]
    for part, kind, label in FINAL:
        expected, true = final(rows, part, kind)
        limit = limit_in_words(expected, part) if {row["layout"] for row in rows} == {CHANCE_LAYOUT} else ""
        lines.append(f"    {label}: {in_words(expected, true)}{limit}")
    finals = [final(rows, part, kind) for part, kind, _ in FINAL]
    expected, true = (np.concatenate([pair[side] for pair in finals]) for side in (0, 1))
    lines.append(f"    together: {in_words(expected, true)}")
    return "\n".join(lines)


def limit_in_words(expected: np.ndarray, part: str) -> str:
    """Return the largest log-correlation that chance leaves to a perfect prediction, where it was measured."""
    if part not in CHANCE:
        return ""
    spread = float(np.std(np.log(expected)))
    return f"; chance leaves a perfect prediction {spread / math.hypot(spread, CHANCE[part]):.2f}"


def in_words(expected: np.ndarray, true: np.ndarray) -> str:
    """Return `agreement` in words, with the number of cameras."""
    correlation, within = agreement(expected, true).split()
    return f"{len(true)} cameras, log-correlation {correlation}, true within {WITHIN} x expected in {within}"


def plot(rows: list[dict], path: Path) -> None:
    """Draw true against expected error."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(figsize=(6.0, 5.0), layout="constrained")
    for part, label, colour in (
        ("along_scan", "scans", "#1f77b4"),
        ("along_hand", "sets by hand", "#ff7f0e"),
    ):
        _, expected, true = np.array([point for row in rows for point in row[part]]).T
        axes.loglog(expected, true, ".", markersize=4, alpha=0.5, color=colour, label=label)
    ends = np.array(axes.get_xlim())
    axes.loglog(ends, ends, color="black", linewidth=0.8, label="true = expected")
    axes.loglog(
        ends, WITHIN * ends, color="black", linewidth=0.8, linestyle="--", label=f"{WITHIN} x expected"
    )
    axes.set(xlabel="expected error over the image [px]", ylabel="true error over the image [px]", xlim=ends)
    axes.legend()
    figure.savefig(path, dpi=110)


def main() -> None:
    """Run what is missing and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=100)
    parser.add_argument("--layout", choices=sorted(LAYOUTS), default="mixed3")
    parser.add_argument("--out", type=Path, default=Path("out/camera_scan.jsonl"))
    parser.add_argument("--table", action="store_true", help="print what is there, run nothing")
    parser.add_argument("--plot", type=Path, help="draw true against expected error into this file")
    options = parser.parse_args()
    cv2.setNumThreads(1)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    lines = options.out.read_text().splitlines() if options.out.exists() else []
    rows = [json.loads(line) for line in lines]
    done = {row["seed"] for row in rows if row["layout"] == options.layout}
    for seed in range(0 if options.table else options.runs):
        if seed not in done:
            rows.append(run(seed, options.layout))
            with options.out.open("a") as file:
                file.write(json.dumps(rows[-1]) + "\n")
    for layout in sorted({row["layout"] for row in rows}):
        print(table([row for row in rows if row["layout"] == layout]))
    print(together(rows))
    if options.plot is not None:
        plot(rows, options.plot)


if __name__ == "__main__":
    main()
