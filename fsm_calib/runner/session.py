"""Builds a run from a scenario, new or from where it was killed."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from fsm_calib.actions import ACTIVITIES, ActionSettings, Bench
from fsm_calib.errors import DataError, InputError
from fsm_calib.journal import Journal, read_checkpoint
from fsm_calib.machines.calibration import CALIBRATION
from fsm_calib.robots.connection import Connection
from fsm_calib.runner.connecting import Told, connect, drive_again
from fsm_calib.runner.gallery import Gallery
from fsm_calib.runner.knowledge import teach
from fsm_calib.runner.logged import LoggedRobot
from fsm_calib.runner.loop import Activity, Run, begun_of
from fsm_calib.runner.parts import Parts
from fsm_calib.runner.progress import Observer
from fsm_calib.scenario.models import Scenario
from fsm_calib.scenario.settings import actions_of, limits_of
from fsm_calib.scenario.world import world_of
from fsm_calib.statechart.machinery import Machinery
from fsm_calib.statechart.runtime import Machine
from fsm_calib.world2d.robot import World, WorldSpec
from fsm_calib.world2d.truth import Truth


@dataclass(frozen=True, eq=False)
class Session:
    """A run with everything around it that the activities do not see.

    Parameters
    ----------
    scenario : Scenario
        What was asked for.
    spec : WorldSpec
        The area that the scenario draws; and the simulated robot in it.
    connection : Connection
        The robot, simulated or real.
    limits : dataclass
        The machine's limits.
    settings : ActionSettings
        The actions' settings.
    run : Run
        The run.
    """

    scenario: Scenario
    spec: WorldSpec
    connection: Connection
    limits: Any
    settings: ActionSettings
    run: Run

    @property
    def world(self) -> World | None:
        """The simulated world, whose truth is for scoring and pictures; None when the robot is a real one."""
        return self.connection.world

    @property
    def truth(self) -> Truth | None:
        """What truly is, for scoring and pictures; None when the robot is a real one."""
        return None if self.connection.world is None else self.connection.world.truth


def new_session(
    scenario: Scenario,
    directory: Path,
    parts: Parts,
    observer: Observer,
    machinery: Machinery = CALIBRATION,
) -> Session:
    """Return a run from its beginning; files of an earlier run in `directory` are replaced."""
    return _session(scenario, directory, parts, observer, machinery, None)


def resumed_session(
    scenario: Scenario,
    directory: Path,
    parts: Parts,
    observer: Observer,
    machinery: Machinery = CALIBRATION,
) -> Session:
    """Return a run that goes on after its last whole event, or begins when it has none.

    Raises
    ------
    DataError
        The directory belongs to another scenario, seed or version, or its journal leads to another pose.
    """
    state = read_checkpoint(directory)
    if state is not None:
        check_same(state, identity(scenario, machinery), directory)
    return _session(scenario, directory, parts, observer, machinery, state)


def identity(scenario: Scenario, machinery: Machinery = CALIBRATION) -> dict[str, str]:
    """Return what a run must have in common with the checkpoint it goes on from."""
    text = json.dumps(scenario.model_dump(mode="json"), sort_keys=True)
    return {
        "scenario": hashlib.sha256(text.encode()).hexdigest(),
        "machine": machinery.digest,
        "version": version("fsm-calib"),
    }


DIFFERS = {
    "scenario": "scenario or seed",
    "machine": "machine",
    "version": "version of fsm-calib",
    "given": "set of recordings (--from)",
    "camera": "camera (--calibration)",
}
"""What a checkpoint may belong to another one of."""


def check_same(state: dict[str, Any], wanted: dict[str, str], directory: Path) -> None:
    """Raise `DataError` unless the checkpoint belongs to this scenario, seed and version."""
    for name, value in wanted.items():
        if state.get(name) != value:
            cure = "Give the same scenario and seed, or run again without --resume."
            raise DataError(f"{directory} holds a run of another {DIFFERS[name]}", cure=cure)


def _session(
    scenario: Scenario,
    directory: Path,
    parts: Parts,
    observer: Observer,
    machinery: Machinery,
    state: dict[str, Any] | None,
) -> Session:
    """Build the run; `state` is the checkpoint to go on from."""
    activities = _activities(machinery)
    spec = world_of(scenario)
    limits, settings = limits_of(scenario, spec.scene, machinery), actions_of(scenario, spec.scene)
    with parts.part("compiling"):
        connection = connect(scenario, spec)
    frames = state["frames"] if state else 0
    is_real = connection.world is None
    if state and is_real:
        state = state | state["begun"]
    robot = LoggedRobot(connection.robot, parts, frames, state["time"] if state and is_real else 0.0)
    run = Run(
        machine=_machine(machinery, scenario, limits, state),
        bench=Bench(robot, settings),
        robot=robot,
        journal=Journal(directory, state["journal_length"], state["journal_chain"])
        if state
        else Journal(directory),
        activities=activities,
        pose=connection.pose,
        parts=parts,
        observer=Told(observer, connection) if is_real else observer,
        gallery=_gallery(scenario, directory, state),
        heading=identity(scenario, machinery),
    )
    if state is None:
        teach(run.bench.notebook, scenario, spec.robot)
        run.begun = begun_of(run) if is_real else {}
    if state:
        run.sequence = state["sequence"]
        run.bench.from_state(state["bench"])
        run.bench.seen_frames = state.get("seen_frames", 0)
        run.begun = state["begun"] if is_real else {}
        with parts.part("physics"):
            if connection.world is not None:
                drive_again(connection, connection.world, directory, state)
    return Session(scenario, spec, connection, limits, settings, run)


def _activities(machinery: Machinery) -> dict[str, Activity]:
    """Return what carries out the machine's activities: its own functions, and those of the room `actions`.

    Raises
    ------
    InputError
        An activity has no function.
    """
    known = ACTIVITIES | dict(machinery.does)
    for path, state in machinery.leaves.items():
        if state.do and state.do not in known:
            cure = f"Give {state.do!r} a function in `does`: it takes the bench and returns an Outcome."
            raise InputError(f"nothing does the activity {state.do}", where=f"state {path}", cure=cure)
    return known


def _machine(machinery: Machinery, scenario: Scenario, limits: Any, state: dict[str, Any] | None) -> Machine:
    """Return the machine at its beginning or where the checkpoint stands."""
    if state is None:
        return Machine(machinery, limits, scenario.plan)
    books = machinery.books.from_dict(state["books"])
    return Machine(machinery, limits, books=books, state=state["state"])


def _gallery(scenario: Scenario, directory: Path, state: dict[str, Any] | None) -> Gallery:
    """Return the gallery; its frames are shared out among the phases."""
    most = -(-scenario.output.frames // max(len(scenario.plan), 1))
    return Gallery.from_state(directory, most, state["gallery"] if state else [])
