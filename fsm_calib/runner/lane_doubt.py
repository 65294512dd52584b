"""What the refinement in the lane leaves open: a k that differs from drive to drive, which no single number mends.

The drives' own turns, as the robot's camera measured them, tell which effect is likely, and what drive would settle it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fsm_calib.actions.leaving import speed_of
from fsm_calib.actions.notebook import WheelRun
from fsm_calib.diagnosis.design.area import Area
from fsm_calib.diagnosis.design.designer import design, played
from fsm_calib.diagnosis.design.from_turns import ONCE, OWN_TURN, Straights, TurnBelief, belief_of_turns
from fsm_calib.diagnosis.design.plan import Plan
from fsm_calib.journal import JOURNAL_NAME, read_journal
from fsm_calib.recording.recording import RobotFacts
from fsm_calib.runner.recording import commands_of
from fsm_calib.runner.session import Session
from fsm_calib.types import WheelCalibration
from fsm_calib.world2d.rollout import Drive

DRIVE, MEASURE = "drive_to_next_marker", "ratio_measured"
"""The activity that drives straight, and the trigger that says what came of it."""
RARE = 3.0
"""Drives that differ by so many standard deviations more than they should are asked about [1]."""
LONGEST = 30.0
"""Longest drive that is proposed [s]."""
NAMED, TOLD = 0.5, 3
"""Probability from which one name is said alone [1], and how many are said else."""
AGAIN = "Something happened once, to one of them: a push, a spot on the floor or a turned marker. Drive there again."


@dataclass(frozen=True, eq=False)
class LaneDoubt:
    """The scatter of k over the drives [1], what likely makes it, and the drive that would settle it."""

    scatter: float
    drives: int
    found: TurnBelief
    plan: Plan | None

    @property
    def sentence(self) -> str:
        """What is said of it."""
        begin = f"k differs by {self.scatter:.3f} over {self.drives} drives: no single k mends that."
        likely = self.found.probabilities[:TOLD]
        if likely[0][0] == ONCE and likely[0][1] >= NAMED:
            return f"{begin} {AGAIN}"
        if likely[0][0] == "":
            return f"{begin} What makes it differ they do not tell.{self._settled}"
        names = [(name, p) for name, p in likely if name not in ("", ONCE)]
        if names and names[0][1] >= NAMED:
            names = names[:1]
        said = " or ".join(f"{name} ({p:.0%})" for name, p in names) or "nothing of the catalogue"
        return f"{begin} Likely {said}.{self._settled}"

    @property
    def _settled(self) -> str:
        if self.plan is None:
            return ""
        return f" A drive of {self.plan.seconds:.0f} s {self.plan.why}: `fsm-calib investigate` makes such drives."

    def as_json(self) -> dict[str, Any]:
        """Return plain values."""
        likely = [
            {"name": name or "nothing", "probability": round(p, 4)}
            for name, p in self.found.probabilities[: TOLD + 1]
        ]
        holds = [] if self.plan is None else [list(hold) for hold in self.plan.holds]
        drive = None if self.plan is None else {**self.plan.as_json(), "holds": holds}
        return {"sentence": self.sentence, "scatter": self.scatter, "likely": likely, "drive": drive}


def lane_doubt(session: Session, directory: Path) -> LaneDoubt | None:
    """Return what the lane's drives leave open; None where they agree as well as such drives do, or are too few."""
    notebook, settings = session.run.bench.notebook, session.settings
    if len(notebook.lane_runs) < settings.lane.least_readings or agree(notebook.lane_runs):
        return None
    events = list(read_journal(directory / JOURNAL_NAME))
    commands = commands_of(events)
    full = speed_of(session.run.bench) / (notebook.drive_command or settings.drive.command)
    radius = WheelCalibration().wheel_radius
    facts = RobotFacts(
        session.scenario.robot.name, radius, settings.ratio.axle_length, max_wheel_rate=full / radius
    )
    found = belief_of_turns(
        straights_of(notebook.lane_runs, events),
        Drive(commands.time, commands.left, commands.right),
        facts,
        notebook.lane_runs[-1].wheel_ratio,
    )
    area = Area()
    plan = design(
        found.belief, area, area.centre, np.random.default_rng(session.scenario.seed), played(LONGEST)
    )
    scatter = float(np.std([run.k_i for run in notebook.lane_runs]))
    return LaneDoubt(scatter, len(notebook.lane_runs), found, plan if isinstance(plan, Plan) else None)


def agree(runs: Sequence[WheelRun]) -> bool:
    """Return whether drives turn alike for their ways, as far as markers and drives are good for it."""
    turned, way = np.array([run.turned for run in runs]), np.array([run.distance for run in runs])
    variance = np.array([run.sd for run in runs]) ** 2 + OWN_TURN**2
    slope = (turned @ (way / variance)) / (way @ (way / variance))
    freedom = len(runs) - 1
    return float(np.sum((turned - slope * way) ** 2 / variance)) <= freedom + RARE * math.sqrt(2.0 * freedom)


def straights_of(runs: Sequence[WheelRun], events: Sequence[Mapping[str, Any]]) -> Straights:
    """Return the drives of the lane with the times of their commands, of the events of a journal."""
    drives: list[Mapping[str, Any]] = []
    begun: Mapping[str, Any] | None = None
    for event in events:
        if event["activity"] == DRIVE:
            begun = event
        elif event["trigger"] == MEASURE and begun is not None:
            drives.append(begun)
            begun = None
    drives = drives[-len(runs) :]
    return Straights(
        begin=np.array([event["commands"][0][0] for event in drives]),
        stop=np.array([event["commands"][-1][0] for event in drives]),
        way=np.array([run.distance for run in runs]),
        turned=np.array([run.turned for run in runs]),
        sd=np.array([run.sd for run in runs]),
    )
