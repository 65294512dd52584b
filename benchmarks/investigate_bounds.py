"""Does a robot ever leave the area? Drives planned without knowing what is wrong with it, cut by the tracker.

    python3 benchmarks/investigate_bounds.py [--robots 40]

The hardest case of an investigation: nothing is diagnosed, so that every drive is planned for a nominal robot (and the
catalogue's typical effects), of manoeuvres drawn at random, while the robot hides one effect of its typical or twice its
typical size: dead zones, slip, patches, tilts, faults. The area is 1.6 x 1.6 m.
"""

from __future__ import annotations

import argparse
import tempfile
from functools import partial
from pathlib import Path

import numpy as np

from fsm_calib.actions.investigating import InvestigationBench
from fsm_calib.diagnosis.design.designer import random_drive
from fsm_calib.outcome import Outcome
from fsm_calib.runner.investigation import session as runs
from fsm_calib.runner.investigation.thinking import Mind
from fsm_calib.runner.loop import run_to_end
from fsm_calib.runner.progress import Silent
from fsm_calib.scenario.models import Scenario
from fsm_calib.world2d.effects import registry

HALF_ROBOT = 0.13  # m: from the axle's centre to the farthest corner of the body


class Ignorant(Mind):
    """Never diagnoses: believes what was believed before the first drive."""

    def _believed(self, bench: InvestigationBench) -> None:
        return None

    def diagnose_drives(self, bench: InvestigationBench) -> Outcome:
        return Outcome("diagnosed")


def hidden(number: int) -> dict:
    names = [e.name for e in registry().values() if e.family != "base"]
    name = names[number % len(names)]
    size = 1.0 + (number // len(names)) % 2
    return {
        name: {
            p.name: float(np.clip(p.null + size * (p.typical - p.null), p.low, p.high))
            if p.strength
            else p.typical
            for p in registry()[name].parameters
        }
    }


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robots", type=int, default=40)
    asked = parser.parse_args()
    runs.Mind = Ignorant  # type: ignore[misc]
    nearest, cuts, drives, ended = [], 0, 0, []
    for number in range(asked.robots):
        scenario = Scenario.model_validate(
            {
                "name": f"robot-{number}",
                "seed": 5000 + number,
                "robot": {"effects": hidden(number)},
                "scene": {"boards": {"placed": ({"board": {}, "x": 3.0, "y": 0.0},)}},
                "investigate": {"budget": 45.0, "width": 1.6, "depth": 1.6},
            }
        )
        with tempfile.TemporaryDirectory() as folder:
            designer = partial(random_drive, seconds=12.0)
            going = runs.session(scenario, Path(folder), runs.Before(), False, Silent(), designer)
            run_to_end(going.run)
            going.run.journal.close()
        trace = going.connection.world.truth.trace
        nearest.append(float(np.min(0.8 - np.abs(trace[:, 1:3]))))
        cuts += sum(d.cut for d in going.bench.findings.drives)
        drives += len(going.bench.findings.drives)
        ended.append(going.run.machine.state)
        print(number, next(iter(hidden(number))), f"{nearest[-1]:.3f} m", ended[-1], flush=True)
    beyond = sum(d < HALF_ROBOT for d in nearest)
    print(f"{asked.robots} robots, {drives} drives, {cuts} cut at the edge")
    print(f"nearest axle's centre to an edge: {min(nearest):.3f} m; body over the edge: {beyond} robots")


if __name__ == "__main__":
    main()
