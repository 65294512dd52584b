"""Fit some runs of four real robots, judge on others: `python3 benchmarks/real_robots.py [ROBOT...]` (5 min of one core).

Prints the tables of docs/robots/*.md and draws their pictures. Errors are measured minus simulated over whole windows,
the simulation driven by the recorded commands alone from the window's first pose; windows with a gap in the poses or
the commands are left out. Results go to out/real_robots.jsonl, robots found there are not diagnosed again.
"""

from __future__ import annotations

import json
import os
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from fsm_calib.diagnosis.diagnose import Diagnosis, diagnose
from fsm_calib.diagnosis.fitting.fit import Engine
from fsm_calib.diagnosis.intake import take_in
from fsm_calib.diagnosis.proof.transfer import on_new_recording
from fsm_calib.diagnosis.replay.prepared import prepare
from fsm_calib.diagnosis.replay.simulator import Simulator, make_simulator, nominal_values
from fsm_calib.recording import read_recording
from fsm_calib.recording.recording import Recording
from fsm_calib.types import FloatArray

ROOT = Path(__file__).parent.parent
SHARED = Path(os.environ.get("FSM_CALIB_SHARED", ROOT.parent / "shared")) / "recordings"
RESULTS = ROOT / "out" / "real_robots.jsonl"
PICTURES = ROOT / "docs" / "robots"
WINDOW_STEP = 0.25  # s between starts of windows
TURNED = 0.1  # rad/s of simulated turning, mean over a window, from which it counts as a turn


@dataclass(frozen=True)
class Robot:
    """What is fitted, what is judged, and how: channel 0 distance [m] or 2 turn [rad], over `horizon` [s]."""

    name: str
    fitted: tuple[str, ...]
    judged: tuple[str, ...]
    channel: int
    horizon: float
    turning: bool = False


ROBOTS = (
    Robot("duckiebot-watchtower", ("b1-run1", "b2-run1"), ("b1-run3", "b1-run5", "b1-run7", "b2-run3", "b2-run5", "b2-run7"), 2, 1.0),
    Robot("mrclam-create", ("ds6-robot1",), ("ds6-robot3", "ds6-robot5", "ds7-robot2", "ds7-robot4"), 0, 5.0, True),
    Robot("husky-skidsteer", ("run0", "run1"), ("run2", "run3"), 2, 1.0),
    Robot("khepera3", ("l90",), (), 2, 5.0),
)  # fmt: skip


def read(robot: Robot, run: str) -> Recording:
    """Return one run's recording."""
    return read_recording(str(SHARED / robot.name / f"{run}.recording.yaml"))


def window_errors(simulator: Simulator, simulated: FloatArray, robot: Robot) -> FloatArray:
    """Return start time [s], measured and simulated motion over each window, shape (w, 3)."""
    p = simulator.prepared
    measured = np.cumsum(p.step[:, robot.channel])
    if robot.channel == 2:
        measured = np.interp(p.time, p.poses.time, p.poses.theta)
    modelled, turned = np.cumsum(simulated[:, robot.channel]), np.cumsum(np.abs(simulated[:, 2]))
    breaks, rows = np.cumsum(p.restart), []
    wide = np.cumsum(p.dt > 0.5 + float(p.geometry[2]))
    for begin in np.arange(p.time[0], p.time[-1] - robot.horizon, WINDOW_STEP):
        a = int(np.searchsorted(p.time, begin))
        b = int(np.searchsorted(p.time, p.time[a] + robot.horizon))
        if b >= len(p.time) or breaks[a] != breaks[b] or wide[a] != wide[b]:
            continue
        if robot.turning and turned[b] - turned[a] < TURNED * robot.horizon:
            continue
        rows.append((p.time[a], measured[b] - measured[a], modelled[b] - modelled[a]))
    return np.array(rows).reshape(-1, 3)


def rms(rows: FloatArray) -> float:
    """Return the root mean square of measured minus simulated of `window_errors`."""
    return float(np.sqrt(np.mean((rows[:, 1] - rows[:, 2]) ** 2))) if len(rows) else float("nan")


def judge(robot: Robot, result: Diagnosis) -> dict[str, Any]:
    """Return the rms error of each judged run: as stated, base re-fitted, with the effects; draw the first run."""
    train = result.decision.engine.simulators
    found: dict[str, Any] = {}
    pooled: dict[str, list[FloatArray]] = {"stated": [], "base": [], "after": []}
    for run in robot.judged:
        taken = take_in([read(robot, f) for f in robot.fitted], [read(robot, run)])
        simulator = make_simulator(prepare(taken.holdout[0]))
        stated = nominal_values([simulator])[None]
        after = on_new_recording(Engine((simulator,)), result.decision.model.fit)
        models = {"stated": stated, "base": result.decision.base.values[:1], "after": after}
        rows = {
            name: window_errors(simulator, simulator.increments(v)[0], robot) for name, v in models.items()
        }
        found[run] = {name: rms(r) for name, r in rows.items()} | {"windows": len(rows["after"])}
        for name, r in rows.items():
            pooled[name].append(r)
        if run == robot.judged[0]:
            draw(robot, run, rows)
    if robot.judged:
        found["all"] = {name: rms(np.vstack(r)) for name, r in pooled.items()}
        found["all"]["windows"] = sum(map(len, pooled["after"]))
    elif train:
        draw(robot, robot.fitted[0], {
            name: window_errors(train[0], fit.simulated[0], robot)
            for name, fit in (("base", result.decision.base), ("after", result.decision.model.fit))
        })  # fmt: skip
    return found


def draw(robot: Robot, run: str, rows: dict[str, FloatArray]) -> None:
    """Draw the error over time of one run."""
    colours = {"stated": "#9aa0a6", "base": "#d95f0e", "after": "#2b7bba"}
    names = {"stated": "robot as stated", "base": "base robot re-fitted", "after": "with what was found"}
    figure, axis = plt.subplots(figsize=(8.0, 2.4), layout="constrained")
    for name, r in rows.items():
        if len(r):
            axis.plot(r[:, 0], r[:, 1] - r[:, 2], ".", markersize=2.5, color=colours[name], label=names[name])
    what = "turn [rad]" if robot.channel == 2 else "distance [m]"
    axis.set(
        xlabel="time [s]", ylabel=f"error of {what}", title=f"{robot.name} {run}, {robot.horizon:g} s windows"
    )
    axis.legend(fontsize=7, markerscale=3, ncols=3)
    axis.grid(alpha=0.3)
    PICTURES.mkdir(parents=True, exist_ok=True)
    figure.savefig(PICTURES / f"{robot.name}.png", dpi=90)
    plt.close(figure)


def examine(robot: Robot) -> dict[str, Any]:
    """Diagnose one robot and judge the result."""
    result = diagnose([read(robot, run) for run in robot.fitted])
    verdict = result.verdict.as_json()
    return {
        "robot": asdict(robot), "verdict": verdict["verdict"], "reason": verdict["reason"], "effects": verdict["effects"],
        "rivals": verdict["rivals"], "located": verdict["located"], "smallest_seen": verdict["smallest_seen"],
        "base": verdict["fit"]["base"], "train": verdict["fit"]["train"], "seconds": verdict["seconds"],
        "notes": list(result.notes), "judged": judge(robot, result),
    }  # fmt: skip


def table(found: dict[str, Any]) -> str:
    """Return one robot's answer and its table in Markdown."""
    robot, unit = found["robot"], "rad" if found["robot"]["channel"] == 2 else "m"
    lines = [f"{robot['name']}: {found['verdict']}, {found['reason']} ({found['seconds']:.0f} s)"]
    lines += [f"  {e['name']} (confidence {e['confidence']:.2f}): {e['sentence']}" for e in found["effects"]]
    lines += [f"  rival {r['name']}: {r['evidence_gap']:.0f} behind" for r in found["rivals"][:3]]
    if found["judged"]:
        lines += [
            f"| run | windows | as stated [{unit}] | base re-fitted | with what was found |",
            "|---|---|---|---|---|",
        ]
        lines += [
            f"| {run} | {e['windows']} | {e['stated']:.3f} | {e['base']:.3f} | {e['after']:.3f} |"
            for run, e in found["judged"].items()
        ]
    return "\n".join(lines)


def main(names: list[str]) -> None:
    """Examine the named robots, or all, that have no result yet; print all their tables."""
    done: dict[str, Any] = {}
    if RESULTS.exists():
        done = {row["robot"]["name"]: row for row in map(json.loads, RESULTS.read_text("utf-8").splitlines())}
    RESULTS.parent.mkdir(exist_ok=True)
    for robot in ROBOTS:
        if names and robot.name not in names:
            continue
        if robot.name not in done:
            done[robot.name] = examine(robot)
            with RESULTS.open("a", encoding="utf-8") as file:
                file.write(json.dumps(done[robot.name]) + "\n")
        print(table(done[robot.name]), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
