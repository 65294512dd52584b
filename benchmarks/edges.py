"""How often a calibration is reported done that is not good, over robots from the edges of what occurs.

    python benchmarks/edges.py [--robots 500] [--first 0] [--jobs 2]

Each robot is drawn from the fleet and then moved to an edge by its number: motors up to 30 % apart, soft tyres, wheels
off their centre, commands late, dim light, noise, slow shutter, defocus, and for every second one a fault at a random
moment. A *wrong done* ends in `done` with a deviation beyond 10 cm after 2 m (with the calibration that the robot is left with) or
a camera error beyond twice its own prediction, which 95 of 100 such calibrations should stay within: how many do, and
how many good results were refused, is told beside it. A run that its fault cut short, with what it had calibrated until
then in order, is told apart from a refusal: what is left of the run could not be driven. Results are kept in
out/benchmarks/, so that an interrupted call goes on.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Mapping
from typing import Any

import fleet_runs
import numpy as np

NAME, SCENARIO = "edges", "full_calibration"
LARGEST_DEVIATION = 0.10  # m after 2 m
LARGEST_RATIO = 2.0  # true camera error over the predicted one
LONGEST_RUN = 600.0  # s of robot time among which a fault may begin


def edges_of(seed: int) -> tuple[str, dict[str, Any]]:
    """Return what is at an edge for this robot, and the changes of its scenario."""
    rng = np.random.default_rng([seed, 22])
    robot: dict[str, Any] = {"effects": {}}
    sensor: dict[str, Any] = {}
    names = rng.choice(list(EDGES), size=int(rng.integers(1, 4)), replace=False).tolist()
    for name in names:
        EDGES[name](rng, robot, sensor)
    changes: dict[str, Any] = {"robot": robot, "sensor": sensor}
    if seed % 2:
        fault = FAULTS[int(rng.integers(len(FAULTS)))](rng)
        changes["faults"] = [fault | {"at": float(rng.uniform(0.0, LONGEST_RUN))}]
        names.append(fault["kind"])
    return " + ".join(sorted(names)), changes


def _apart(rng: np.random.Generator, robot: dict[str, Any], sensor: dict[str, Any]) -> None:
    robot["wheel_ratio"] = float(rng.choice([0.77, 0.85, 1.18, 1.30]) * rng.uniform(0.98, 1.02))


def _effect(name: str, key: str, low: float, high: float) -> Any:
    def apply(rng: np.random.Generator, robot: dict[str, Any], sensor: dict[str, Any]) -> None:
        robot["effects"][name] = {key: float(rng.uniform(low, high))}

    return apply


def _sensor(key: str, low: float, high: float) -> Any:
    def apply(rng: np.random.Generator, robot: dict[str, Any], sensor: dict[str, Any]) -> None:
        sensor[key] = float(rng.uniform(low, high))

    return apply


def _typical(name: str) -> Any:
    """Return an edge of an effect at the size that its file calls typical."""

    def apply(rng: np.random.Generator, robot: dict[str, Any], sensor: dict[str, Any]) -> None:
        robot["effects"][name] = {}

    return apply


EDGES: dict[str, Any] = {
    "motors apart": _apart,
    "soft tyres": _typical("wheel_slip"),
    "lateral slip": _typical("lateral_slip"),
    "eccentric wheel": _typical("wheel_eccentricity"),
    "caster": _typical("caster_drag"),
    "late commands": _typical("command_delay"),
    "dead band": _typical("motor_deadband"),
    "dim": _sensor("brightness", 0.25, 0.5),
    "glare": _sensor("brightness", 1.5, 2.2),
    "noise": _sensor("read_noise", 4.0, 10.0),
    "slow shutter": _sensor("exposure", 0.02, 0.05),
}
FAULTS: tuple[Any, ...] = (
    lambda rng: {"kind": "dead_wheel", "side": str(rng.choice(["left", "right"]))},
    lambda rng: {"kind": "frozen_frames"},
    lambda rng: {"kind": "dropped_frames", "share": float(rng.uniform(0.2, 1.0))},
    lambda rng: {"kind": "missing_board", "board": int(rng.integers(3))},
    lambda rng: {"kind": "missing_markers"},
    lambda rng: {"kind": "blurred_camera", "defocus": float(rng.uniform(1.0, 6.0))},
)


def deviation_of(row: Mapping[str, Any]) -> float:
    """Return the deviation after 2 m [m] with the calibration that the robot is left with; infinite for no drive."""
    lane, wheels = row["in_lane"] or {}, row["wheels"] or {}
    value = lane.get("deviation_after_m", wheels.get("deviation_2m_m"))
    return float("inf") if value is None else abs(value)


def is_good(row: Mapping[str, Any]) -> bool:
    """Tell whether a calibration is what it is reported to be."""
    camera = row["camera"]
    if not camera or deviation_of(row) > LARGEST_DEVIATION:
        return False
    return bool(camera["true_px"] <= LARGEST_RATIO * camera["predicted_px"])


def tell(row: Mapping[str, Any]) -> None:
    camera = row["camera"] or {}
    print(
        f"seed {row['seed']:4d}  {fleet_runs.ended(row):40s}  {100 * deviation_of(row):6.1f} cm  camera "
        f"{camera.get('true_px', np.nan):5.2f} px of {camera.get('predicted_px', np.nan):5.2f}  {row['label']}",
        flush=True,
    )


def tell_predictions(rows: list[dict[str, Any]]) -> None:
    """Print how true errors of the cameras stand to the predicted and the expected ones, in what was reported done."""
    cameras = [row["camera"] for row in rows if row["camera"]]
    true, predicted, expected = (
        np.array([camera[name] for camera in cameras]) for name in ("true_px", "predicted_px", "expected_px")
    )
    print(
        f"cameras: true {np.median(true):.2f}, predicted {np.median(predicted):.2f}, expected {np.median(expected):.2f} px "
        f"(medians); {np.mean(true <= predicted):.1%} within the predicted error; true / predicted: median "
        f"{np.median(true / predicted):.2f}, largest {np.max(true / predicted):.2f}; true / expected: median "
        f"{np.median(true / expected):.2f}, root mean square {np.sqrt(np.mean((true / expected) ** 2)):.2f}, "
        f"{np.mean(true > LARGEST_RATIO * expected):.1%} beyond twice"
    )


def tell_refusals(rows: list[dict[str, Any]]) -> None:
    """Print how many good results were not reported as such: the run did not end in done, or without the asked error."""
    good = [row for row in rows if is_good(row)]
    ended = [row for row in good if row["outcome"] != "done"]
    refused = [row for row in ended if not fault_of(row)]
    short = [row for row in good if row["outcome"] == "done" and not row["camera"]["reached"]]
    cut = Counter(f"{fault_of(row)}: {fleet_runs.ended(row).split()[0]}" for row in ended if fault_of(row))
    print(
        f"{len(good)} good results: {len(refused)} of them refused ({len(refused) / max(len(good), 1):.1%}); "
        f"{cut.total()} cut short by their fault ({dict(cut)}); {len(short)} done but for the camera error that was asked for"
    )


def fault_of(row: Mapping[str, Any]) -> str:
    """Return the kind of the fault that had begun when a run ended; empty for none."""
    faults = edges_of(row["seed"])[1].get("faults", ())
    return next((str(f["kind"]) for f in faults if f["at"] < row["seconds"]["simulated"]), "")


def report(rows: list[dict[str, Any]]) -> bool:
    """Print the figures; return whether no wrong result passed for a right one."""
    done = [row for row in rows if row["outcome"] == "done"]
    wrong = [row for row in done if not is_good(row)]
    print(
        f"\n{len(done)} of {len(rows)} done, {len(wrong)} of them wrong; ends: {dict(Counter(map(fleet_runs.ended, rows)))}"
    )
    for row in wrong:
        tell(row)
    tell_predictions(done)
    tell_refusals(rows)
    return not wrong


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", type=int, default=500)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    tasks: list[fleet_runs.Task] = []
    for seed in range(options.first, options.first + options.robots):
        label, changes = edges_of(seed)
        tasks.append((label, seed, changes))
    return int(not report(fleet_runs.run_all(NAME, SCENARIO, tasks, options.jobs, tell)))


if __name__ == "__main__":
    sys.exit(main())
