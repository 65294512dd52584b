"""Faults that begin in a state of a run: where they begin, what they are, and how a run may end that has them."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from campaign_case import Case, Wrong
from campaign_children import started
from edges import FAULTS, LARGEST_DEVIATION, LARGEST_RATIO
from fleet_runs import NO_PICTURES, SCENARIOS

from fsm_calib.errors import FsmCalibError
from fsm_calib.journal import JOURNAL_NAME

RUNS = (*["wheels_only", "exit"] * 2, "camera_only", "in_lane_refinement", "full_calibration")
"""Scenarios in whose states faults begin: each part by itself, and all of them in a row."""
ROBOTS = 4  # of each scenario
LONGEST_RUN = 900.0
"""Robot time within which every run has ended by its own limits [s]."""
LIGHTS = ((0.05, 0.3), (1.8, 3.0))
"""Brightness of a dark room and of a glaring one; the usual one is 1."""
WALL = (0.25, 0.7)  # m before the robot


@dataclass(frozen=True)
class Span:
    """A stay in a state: its path, robot time from `begin` to `end` [s], and the pose (x, y, theta) at its beginning."""

    state: str
    begin: float
    end: float
    pose: tuple[float, float, float]


def spans_of(directory: Path) -> list[Span]:
    """Return the stays in states that take time, in their order, from a run's journal."""
    rows = [json.loads(line) for line in (directory / JOURNAL_NAME).read_text().splitlines()]
    starts = [(0.0, (0.0, 0.0, 0.0)), *((row["time"], tuple(row["pose"])) for row in rows)]
    spans = [Span(row["path"], *starts[i][:1], row["time"], starts[i][1]) for i, row in enumerate(rows)]
    return [span for span in spans if span.end > span.begin]


def state_at(spans: list[Span], moment: float) -> str:
    """Return the state in which a run was at a moment; empty after its end."""
    return next((span.state for span in spans if span.begin <= moment < span.end), "")


def faults(case: Case) -> None:
    """Let one or two faults begin in states drawn evenly: the run ends by name, wheels at zero, in time; `done` is good."""
    name, seed = case.rng.choice(RUNS), case.rng.randrange(ROBOTS)
    spans = spans_of(case.reference(name, seed, pictures=False))
    chosen = [_drawn(case, spans) for _ in range(case.rng.choice((1, 1, 2)))]
    if len({fault.get("board", -1 - i) for i, fault in enumerate(chosen)}) < len(chosen):
        chosen.pop()  # a board is taken away once
    light = case.rng.uniform(*case.rng.choice(LIGHTS)) if case.rng.random() < 0.15 else 1.0
    case.choose(scenario=name, seed=seed, faults=chosen, brightness=light)
    changes = {"seed": seed, "faults": chosen, "output": NO_PICTURES}
    child = started(lambda: _run_with(case.folder, name, changes, light), case.folder / "log").wait()
    if child.code:
        raise Wrong(f"exit code {child.code}: {child.stderr().strip().splitlines()[-1:]}")
    row = json.loads((case.folder / "row.json").read_text())
    own = spans_of(case.folder / "out")
    case.choose(
        ended=row["outcome"] if row["failure"] is None else row["failure"]["name"],
        began=[state_at(own, fault["at"]) for fault in chosen],
    )
    expect_named(row)


def _drawn(case: Case, spans: list[Span]) -> dict[str, Any]:
    """Return a fault that begins in a state, every state with the same chance."""
    state = case.rng.choice(sorted({span.state for span in spans}))
    span = case.rng.choice([span for span in spans if span.state == state])
    at = {"at": case.rng.uniform(span.begin, span.end)}
    number = case.rng.randrange(len(FAULTS) + 1)
    if number < len(FAULTS):
        return FAULTS[number](np.random.default_rng(case.rng.randrange(1 << 30))) | at
    return {"kind": "obstacle", "wall": _wall_before(span.pose, case.rng.uniform(*WALL))} | at


def _wall_before(pose: tuple[float, float, float], distance: float) -> dict[str, float]:
    """Return a wall of 0.6 m across the way of a robot, `distance` [m] before it."""
    x, y, theta = pose
    x, y = x + distance * math.cos(theta), y + distance * math.sin(theta)
    across = (-0.3 * math.sin(theta), 0.3 * math.cos(theta))
    return {"x0": x - across[0], "y0": y - across[1], "x1": x + across[0], "y1": y + across[1], "height": 0.1}


def _run_with(folder: Path, name: str, changes: dict[str, Any], light: float) -> int:
    """Run in this process and leave the result, the last wheel command included."""
    from fsm_calib.runner.run import run_scenario
    from fsm_calib.scenario.load import load_scenario
    from fsm_calib.scenario.models import Scenario

    values = load_scenario(SCENARIOS / f"{name}.yaml").model_dump(exclude_unset=True) | changes
    if light != 1.0:
        values["sensor"] = {"brightness": light}
    try:
        finished = run_scenario(Scenario.model_validate(values), folder / "out")
    except FsmCalibError as error:
        print(error, file=sys.stderr)
        return 3
    last = finished.session.world.robot.command_log[-1][1]  # type: ignore[union-attr]
    row = finished.result | {"last_command": [last.left, last.right]}
    (folder / "row.json").write_text(json.dumps(row))
    return 0


def expect_named(row: Mapping[str, Any]) -> None:
    """Demand that a run says how it ended, stands still, and claims nothing that is not so."""
    failure = row["failure"]
    if row["last_command"] != [0.0, 0.0]:
        raise Wrong(f"wheels at {row['last_command']}")
    if row["seconds"]["simulated"] > LONGEST_RUN:
        raise Wrong(f"{row['seconds']['simulated']:.0f} s of robot time")
    if row["outcome"] == "done":
        expect_good(row)
    elif failure is None or not all(failure[key].strip() for key in ("name", "reason", "cure")):
        raise Wrong(f"ended without a name: {failure}")


def expect_good(row: Mapping[str, Any]) -> None:
    """Demand of what a run that is done has calibrated that it is good: the camera, the wheels, the change in the lane."""
    camera, wheels, lane = row["camera"], row["wheels"], row["in_lane"]
    if camera and camera["true_px"] > LARGEST_RATIO * camera["predicted_px"]:
        raise Wrong(
            f"done, with a camera of {camera['true_px']:.2f} px where {camera['predicted_px']:.2f} were predicted"
        )
    if wheels and abs(wheels["deviation_2m_m"]) > LARGEST_DEVIATION:
        raise Wrong(f"done, and {wheels['deviation_2m_m']:.3f} m off after 2 m")
    if lane and abs(lane["deviation_after_m"]) > max(LARGEST_DEVIATION, abs(lane["deviation_before_m"])):
        raise Wrong(f"done, and {lane['deviation_after_m']:.3f} m off after 2 m with what the lane told")
