"""What is written of a sealed robot: recordings without a word of truth, and the key that is kept apart."""

from __future__ import annotations

import dataclasses
import gzip
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from foreign.drive import Drive
from foreign.setup import Array, Setup
from foreign.tracker import clean_poses, noisy, ticks

if TYPE_CHECKING:
    from foreign.sealed import Bench


def write(bench: Bench, setup: Setup, drive: Drive, run: str, folder: Path) -> None:
    """Write one recording `fsm-calib/recording@1`."""
    robot, sheet = bench.robot, bench.robot.sheet
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(bench.seed(run) + 2)
    times, poses = clean_poses(setup, drive, robot.sensing["rate"], float(rng.uniform()))
    times, poses = noisy(robot, times, poses, rng)
    twist = robot.command == "twist"
    command = bench.to_twist(drive.duties) if twist else drive.duties
    names = ("v", "omega") if twist else ("left", "right")
    table(folder / "command.csv.gz", ("t", *names), np.column_stack([drive.times, command]), 5)
    table(folder / "pose.csv.gz", ("t", "x", "y", "theta"), np.column_stack([times, poses]), 5)
    body = robot.parts["body"]
    stated = {"mass": body["mass"], "inertia": body["inertia"]} if bench.order.states_mass else {}
    known = ", ".join(f"{k}: {v}" for k, v in (sheet | stated).items())
    lines = [
        "format: fsm-calib/recording@1",
        f"robot: {{name: {robot.name}, {known}}}",
        "channels:",
        f"  command: {{file: command.csv.gz, time: t, {names[0]}: {names[0]}, {names[1]}: {names[1]}, unit: {robot.command}}}",
        "  pose: {file: pose.csv.gz, time: t, x: x, y: y, theta: theta}",
    ]
    counts = ticks(robot, drive, rng)
    if counts is not None:
        table(folder / "ticks.csv.gz", ("t", "left", "right"), counts, 5)
        per_turn = int(robot.sensing["ticks"])
        lines.append(
            f"  wheel_angle: {{file: ticks.csv.gz, time: t, left: left, right: right, unit: tick, ticks_per_turn: {per_turn}}}"
        )
    (folder / "recording.yaml").write_text("\n".join(lines) + "\n")


def table(path: Path, names: tuple[str, ...], values: Array, digits: int) -> None:
    """Write a CSV file, gzipped without a date so that a seed gives the same bytes."""
    text = (
        ",".join(names) + "\n" + "\n".join(",".join(f"{v:.{digits}f}" for v in row) for row in values) + "\n"
    )
    path.write_bytes(gzip.compress(text.encode(), mtime=0))


def key(bench: Bench, shown: list[float], departures: float) -> dict[str, Any]:
    """Return what is true of a robot; numbers in SI units."""
    robot, order = bench.robot, bench.order
    body = robot.parts["body"]
    effects = [
        {
            "label": e.law.label,
            "law": e.law.name,
            "severity": e.size,
            "ratio": value,
            "sizes": plain_numbers(e.sizes or {}),
        }
        for e, value in zip(bench.effects, shown)
    ]
    effects.sort(key=lambda item: -item["ratio"])
    names = sorted(e["label"] for e in effects if e["label"] != "outside")
    place = None if bench.place is None else dataclasses.asdict(bench.place)
    return plain_numbers({
        "name": order.name, "family": order.family, "labels": names, "strongest": effects[0]["label"] if effects else None,
        "effects": effects, "engine": order.engine, "place": place, "windows": bench.windows,
        "departures": {"small": bench.small, "ratio": departures, **dict(robot.departures)},
        "robot": {k: body[k] for k in ("mass", "inertia", "axle", "com_x", "friction", "tyre", "radius_left")},
        "sheet": robot.sheet, "sensing": robot.sensing, "command": robot.command, "seconds": bench.seconds,
    })  # fmt: skip


def plain_numbers(value: Any) -> Any:
    """Turn numpy's numbers into JSON's."""
    if isinstance(value, dict):
        return {str(k): plain_numbers(v) for k, v in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [plain_numbers(v) for v in value]
    if isinstance(value, np.integer | np.floating | np.bool_):
        return value.item()
    return value
