"""Builds a run from a scenario, new or from where it was killed."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from fsm_calib.actions import ACTIVITIES, ActionSettings, Bench
from fsm_calib.errors import DataError
from fsm_calib.journal import JOURNAL_NAME, Journal, read_checkpoint, read_journal
from fsm_calib.machines.books import Books
from fsm_calib.machines.limits import Limits
from fsm_calib.machines.runtime import CalibrationMachine
from fsm_calib.runner.gallery import Gallery
from fsm_calib.runner.knowledge import teach
from fsm_calib.runner.logged import LoggedCommand, LoggedRobot
from fsm_calib.runner.loop import Run
from fsm_calib.runner.parts import Parts
from fsm_calib.runner.progress import Observer
from fsm_calib.scenario.models import Scenario
from fsm_calib.scenario.settings import actions_of, limits_of
from fsm_calib.scenario.world import world_of
from fsm_calib.types import WheelCommand
from fsm_calib.world2d.robot import World, make_world

POSE_TOLERANCE = 1e-9
"""How far a world that was driven again may be from the journal [m, rad]: rounding of another machine."""


@dataclass(frozen=True, eq=False)
class Session:
    """A run with everything around it that the activities do not see.

    Parameters
    ----------
    scenario : Scenario
        What was asked for.
    world : World
        The world; its truth is for scoring and pictures.
    limits : Limits
        The machines' limits.
    settings : ActionSettings
        The actions' settings.
    run : Run
        The run.
    """

    scenario: Scenario
    world: World
    limits: Limits
    settings: ActionSettings
    run: Run


def new_session(scenario: Scenario, directory: Path, parts: Parts, observer: Observer) -> Session:
    """Return a run from its beginning; files of an earlier run in `directory` are replaced."""
    return _session(scenario, directory, parts, observer, None)


def resumed_session(scenario: Scenario, directory: Path, parts: Parts, observer: Observer) -> Session:
    """Return a run that goes on after its last whole event, or begins when it has none.

    Raises
    ------
    DataError
        The directory belongs to another scenario, seed or version, or its journal leads to another pose.
    """
    state = read_checkpoint(directory)
    if state is not None:
        _check_same(state, identity(scenario), directory)
    return _session(scenario, directory, parts, observer, state)


def identity(scenario: Scenario) -> dict[str, str]:
    """Return what a run must have in common with the checkpoint it goes on from."""
    text = json.dumps(scenario.model_dump(mode="json"), sort_keys=True)
    return {"scenario": hashlib.sha256(text.encode()).hexdigest(), "version": version("fsm-calib")}


def _check_same(state: dict[str, Any], wanted: dict[str, str], directory: Path) -> None:
    """Raise `DataError` unless the checkpoint belongs to this scenario, seed and version."""
    for name, value in wanted.items():
        if state.get(name) != value:
            what = "scenario or seed" if name == "scenario" else "version of fsm-calib"
            cure = "Give the same scenario and seed, or run again without --resume."
            raise DataError(f"{directory} holds a run of another {what}", cure=cure)


def _session(
    scenario: Scenario, directory: Path, parts: Parts, observer: Observer, state: dict[str, Any] | None
) -> Session:
    """Build the run; `state` is the checkpoint to go on from."""
    spec = world_of(scenario)
    limits, settings = limits_of(scenario, spec.scene), actions_of(scenario, spec.scene)
    with parts.part("compiling"):
        world = make_world(spec)
    frames = state["frames"] if state else 0
    robot = LoggedRobot(world.robot, parts, frames)
    run = Run(
        machine=_machine(scenario, limits, state),
        bench=Bench(robot, settings),
        robot=robot,
        journal=Journal(directory, state["journal_length"] if state else 0),
        activities=ACTIVITIES,
        pose=lambda: list(_pose(world)),
        parts=parts,
        observer=observer,
        gallery=_gallery(scenario, directory, state),
        heading=identity(scenario),
    )
    if state is None:
        teach(run.bench.notebook, scenario, spec.robot)
    if state:
        run.sequence = state["sequence"]
        run.bench.from_state(state["bench"])
        with parts.part("physics"):
            _drive_again(world, directory, state)
    return Session(scenario, world, limits, settings, run)


def _machine(scenario: Scenario, limits: Limits, state: dict[str, Any] | None) -> CalibrationMachine:
    """Return the machine at its beginning or where the checkpoint stands."""
    if state is None:
        return CalibrationMachine(limits, scenario.plan)
    return CalibrationMachine(limits, books=Books.from_dict(state["books"]), state=state["state"])


def _gallery(scenario: Scenario, directory: Path, state: dict[str, Any] | None) -> Gallery:
    """Return the gallery; its frames are shared out among the phases."""
    most = -(-scenario.output.frames // len(scenario.plan))
    return Gallery.from_state(directory, most, state["gallery"] if state else [])


def _pose(world: World) -> tuple[float, float, float]:
    """Return the true pose [m, m, rad]."""
    pose = world.truth.pose
    return pose.x, pose.y, pose.theta


def _drive_again(world: World, directory: Path, state: dict[str, Any]) -> None:
    """Bring a new world to where the journal ends, and check that it is there."""
    commands: list[LoggedCommand] = []
    pose: list[float] = []
    for event in read_journal(directory / JOURNAL_NAME):
        commands += [tuple(command) for command in event["commands"]]
        pose = event["pose"]
    log = [(time, WheelCommand(left, right)) for time, left, right in commands]
    world.robot.fast_forward(log, state["time"], state["frames"])
    error = float(np.abs(np.subtract(_pose(world), pose)).max())
    if not error <= POSE_TOLERANCE:
        problem = f"driven again, the robot is {error:.3g} m or rad away from where the journal says"
        raise DataError(
            problem, cure="Run again without --resume; the journal was changed or is of another version."
        )
