"""Does a robot ever leave the area? Drives planned without knowing what is wrong with it, cut by the tracker.

    python3 benchmarks/investigate_bounds.py [--robots 300] [--first 0]

The hardest case of an investigation: nothing is diagnosed, so that every drive is planned for a nominal robot (and the
catalogue's typical effects), of manoeuvres drawn at random, while the robot hides one effect of its typical or twice its
typical size: dead zones, slip, patches, tilts, faults. The area is 1.6 x 1.6 m. Since the belief stays the same, what it
expects of a manoeuvre is rolled out once for all robots, and what a drive would promise is not asked.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from functools import cache
from pathlib import Path

import numpy as np

from fsm_calib.actions.investigating import InvestigationBench
from fsm_calib.diagnosis.design.area import Area
from fsm_calib.diagnosis.design.belief import Belief
from fsm_calib.diagnosis.design.belief_of import prior_belief
from fsm_calib.diagnosis.design.designer import REACHES, Composer, NoDrive, Wishes
from fsm_calib.diagnosis.design.foresight import Foresight
from fsm_calib.diagnosis.design.plan import Forecast, Outlook, Plan
from fsm_calib.diagnosis.design.primitives import Primitive
from fsm_calib.outcome import Outcome
from fsm_calib.runner.investigation import session as runs
from fsm_calib.runner.investigation.thinking import Mind
from fsm_calib.runner.loop import run_to_end
from fsm_calib.runner.progress import Silent
from fsm_calib.scenario.models import Scenario
from fsm_calib.types import Pose2
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.obstacles import ROBOT_FRONT, ROBOT_LENGTH, ROBOT_WIDTH

SECONDS = 12.0  # s: least length of a drive, where there is room
NO_FORECAST = Forecast(0.0, 0.0, 0.0, 0.0)
HALF_AREA = 0.8  # m
CORNERS = np.array(
    [
        (x, y)
        for x in (ROBOT_FRONT, ROBOT_FRONT - ROBOT_LENGTH)
        for y in (-0.5 * ROBOT_WIDTH, 0.5 * ROBOT_WIDTH)
    ]
)
"""Of the body, from the axle's centre [m]."""


class Ignorant(Mind):
    """Never diagnoses: believes what was believed before the first drive."""

    def _believed(self, bench: InvestigationBench) -> None:
        return None

    def diagnose_drives(self, bench: InvestigationBench) -> Outcome:
        return Outcome("diagnosed")


@cache
def foresight() -> Foresight:
    """What is expected of manoeuvres before anything was driven, the same for every robot."""
    return Foresight(prior_belief())


def unpromised_drive(
    _: Belief, area: Area, start: Pose2, rng: np.random.Generator, wishes: Wishes
) -> Plan | NoDrive:
    """Return a drive as `random_drive` draws it, within the same bounds, without what it promises."""
    for reach in REACHES:
        composer = Composer.at(foresight(), area, wishes, start, reach)
        if chosen := composer.kept_safe(composer.drawn(SECONDS, rng), rng):
            return planned(composer, chosen, start)
    return NoDrive.NO_ROOM


def planned(composer: Composer, chosen: list[Primitive], start: Pose2) -> Plan:
    """Return manoeuvres as a plan that promises nothing."""
    holds = composer.holds(chosen)
    path = foresight().rolled(holds, foresight().belief.leader.values[None], composer.start)[0]
    return Plan(holds, (), start, NO_FORECAST, (Outlook((), 1.0, 1.0, start, ""),), path)


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


def room_left(trace: np.ndarray) -> tuple[float, float]:
    """Return how near the axle's centre and the body came to an edge [m], by the true poses (n, >= 4) t, x, y, theta."""
    x, y, theta = trace[:, 1:4].T
    c, s = np.cos(theta)[:, None], np.sin(theta)[:, None]
    ahead, aside = CORNERS.T
    reach = np.maximum(np.abs(x[:, None] + c * ahead - s * aside), np.abs(y[:, None] + s * ahead + c * aside))
    centre = np.maximum(np.abs(x), np.abs(y))
    return HALF_AREA - float(centre.max()), HALF_AREA - float(reach.max())


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robots", type=int, default=300)
    parser.add_argument("--first", type=int, default=0, help="number of the first robot")
    asked = parser.parse_args()
    runs.Mind = Ignorant  # type: ignore[misc]
    nearest, bodies, cuts, drives, ended, began = [], [], 0, 0, [], time.process_time()
    for number in range(asked.first, asked.first + asked.robots):
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
            going = runs.session(scenario, Path(folder), runs.Before(), False, Silent(), unpromised_drive)
            run_to_end(going.run)
            going.run.journal.close()
        centre, body = room_left(going.connection.world.truth.trace)
        nearest.append(centre)
        bodies.append(body)
        cuts += sum(d.cut for d in going.bench.findings.drives)
        drives += len(going.bench.findings.drives)
        ended.append(going.run.machine.state)
        print(number, next(iter(hidden(number))), f"{centre:.3f} m, body {body:.3f} m", ended[-1], flush=True)
    beyond = sum(d < 0.0 for d in bodies)
    spent = (time.process_time() - began) / asked.robots
    print(
        f"{asked.robots} robots, {drives} drives, {cuts} cut at the edge; {spent:.1f} s of processor time each"
    )
    print(f"nearest to an edge: axle's centre {min(nearest):.3f} m, body {min(bodies):.3f} m")
    print(f"body over an edge: {beyond} robots")


if __name__ == "__main__":
    main()
