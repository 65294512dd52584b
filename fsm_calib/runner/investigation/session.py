"""Builds an investigation, new or from where it was killed: machine, robot, what tells where it is, what it thinks."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fsm_calib.actions.investigate_settings import InvestigateSettings
from fsm_calib.actions.investigating import ACTIVITIES, InvestigationBench
from fsm_calib.diagnosis.design.area import Area, Disc
from fsm_calib.errors import InputError
from fsm_calib.journal import Journal, read_checkpoint
from fsm_calib.machines.investigate import INVESTIGATE
from fsm_calib.outcome import Outcome
from fsm_calib.recording.recording import Recording, RobotFacts
from fsm_calib.robots.connection import Connection
from fsm_calib.runner.connecting import Told, connect, drive_again
from fsm_calib.runner.gallery import Gallery
from fsm_calib.runner.investigation.own_camera import tracker_of, with_sight
from fsm_calib.runner.investigation.thinking import Designer, Mind, with_facts
from fsm_calib.runner.knowledge import teach, teach_files
from fsm_calib.runner.logged import LoggedRobot
from fsm_calib.runner.loop import Run
from fsm_calib.runner.parts import Parts
from fsm_calib.runner.progress import Observer
from fsm_calib.runner.session import check_same, identity
from fsm_calib.scenario.models import Scenario
from fsm_calib.scenario.world import world_of
from fsm_calib.statechart.runtime import Machine
from fsm_calib.types import WheelCalibration
from fsm_calib.world2d.overhead import OverheadTracker
from fsm_calib.world2d.scene import SceneSpec

WALL_STEP = 0.1  # m between the discs that stand for a wall
ON_THE_FLOOR = ("searching", "returning", "designing", "driving")
"""States in which it matters where the robot is: a real one is looked for again when it goes on."""


@dataclass(frozen=True)
class Before:
    """What was there before: recordings of the robot, and where a run wrote the calibration of its camera."""

    recordings: tuple[Recording, ...] = ()
    calibration: Path | None = None


@dataclass(frozen=True, eq=False)
class Investigation:
    """An investigation while it runs: the loop's run, what it thinks, where it may drive."""

    scenario: Scenario
    run: Run
    bench: InvestigationBench
    mind: Mind
    connection: Connection


def session(
    scenario: Scenario,
    directory: Path,
    before: Before,
    resume: bool,
    observer: Observer,
    designer: Designer,
) -> Investigation:
    """Build an investigation, new or from its checkpoint.

    Raises
    ------
    InputError
        Nothing would tell where the robot is.
    DataError
        The run to go on from belongs to another scenario or other recordings, or its journal is damaged.
    RobotLost
        A real robot does not answer, or must not be driven.
    """
    refuse_blind(scenario, before)
    spec = world_of(scenario)
    state = read_checkpoint(directory) if resume else None
    heading = {**identity(scenario, INVESTIGATE), **_identity(before)}
    if state is not None:
        check_same(state, heading, directory)
    parts = Parts("start")
    connection = connect(scenario, spec)
    is_real = connection.world is None
    began = state["time"] if state and is_real else 0.0
    robot = LoggedRobot(connection.robot, parts, state["frames"] if state else 0, began)
    bench = InvestigationBench(robot, asked=scenario.investigate.build())
    teach(bench.notebook, scenario, spec.robot)
    if before.calibration is not None:
        teach_files(bench.notebook, before.calibration)
    mind = _mind(scenario, bench, connection, before, designer)
    run = Run(
        machine=_machine(state, is_real),
        bench=bench,
        robot=robot,
        journal=Journal(directory, state["journal_length"], state["journal_chain"])
        if state
        else Journal(directory),
        activities=_activities(mind),
        pose=connection.pose,
        parts=parts,
        observer=Told(observer, connection) if is_real else observer,
        gallery=Gallery.from_state(directory, 1, []),
        heading=heading,
    )
    if state is not None:
        _go_on(run, bench, connection, directory, state)
    return Investigation(scenario, run, bench, mind, connection)


def refuse_blind(scenario: Scenario, before: Before) -> None:
    """Refuse a robot of which nothing would tell where it is, before anything is connected.

    Raises
    ------
    InputError
        A real robot without its own camera, or a camera that is not known.
    """
    own = scenario.investigate.poses == "camera"
    if scenario.robot.connect != "simulated" and not own:
        raise InputError(
            "no tracker of ours stands over this robot",
            where="investigate.poses",
            cure="Take `poses: camera` over floor markers, or drive it with `fsm-calib diagnose --plan`.",
        )
    if own and before.calibration is None and not scenario.robot.known.camera:
        raise InputError(
            "the camera is not known",
            where="investigate.poses",
            cure="Give --calibration DIR of an earlier run; a simulated robot may say known: {camera: true}.",
        )


def _identity(before: Before) -> dict[str, str]:
    """Return what an investigation that goes on must have been given before."""
    digest = hashlib.sha256()
    for recording in before.recordings:
        for track in (recording.command, recording.pose):
            if track is not None:
                digest.update(np.ascontiguousarray(track.time).tobytes())
    where = "" if before.calibration is None else str(before.calibration.resolve())
    return {"given": digest.hexdigest(), "camera": hashlib.sha256(where.encode()).hexdigest()}


def _mind(
    scenario: Scenario, bench: InvestigationBench, connection: Connection, before: Before, designer: Designer
) -> Mind:
    """Return what thinks; give the bench its tracker and its bounds."""
    scene, asked = world_of(scenario).scene, bench.asked
    area = area_of(asked, scene)
    bench.clearance = _clearance(area)
    facts = with_facts(_facts(scenario), before.recordings)
    if asked.poses == "camera":
        bench.tracker = tracker_of(bench, scene, asked)
        area = with_sight(area, bench, scene, asked)
        linked = connection.world is None
        return Mind(area, facts, scenario.seed, before.recordings, designer, scene, linked)
    if connection.world is not None:
        bench.tracker = OverheadTracker(connection.world, scenario.tracker.build())
    return Mind(area, facts, scenario.seed, before.recordings, designer)


def _go_on(
    run: Run, bench: InvestigationBench, connection: Connection, directory: Path, state: dict[str, Any]
) -> None:
    """Bring bench, tracker and a simulated world to where the checkpoint stands."""
    run.sequence = state["sequence"]
    bench.from_state(state["bench"])
    if connection.world is not None:
        drive_again(connection, connection.world, directory, state)
    if isinstance(bench.tracker, OverheadTracker):
        bench.tracker.skip(run.robot.now())


def _machine(state: dict[str, Any] | None, is_real: bool) -> Machine:
    if state is None:
        return Machine(INVESTIGATE)
    at = "localising" if is_real and state["state"] in ON_THE_FLOOR else state["state"]
    return Machine(INVESTIGATE, books=INVESTIGATE.books.from_dict(state["books"]), state=at)


def _activities(mind: Mind) -> dict[str, Callable[[Any], Outcome]]:
    thought = (mind.design_drive, mind.diagnose_drives, mind.judge_answer)
    return {**ACTIVITIES, **{activity.__name__: activity for activity in thought}}


def _facts(scenario: Scenario) -> RobotFacts:
    nominal = WheelCalibration()
    return RobotFacts(scenario.robot.name, nominal.wheel_radius, nominal.axle_length, max_wheel_rate=20.0)


def _clearance(area: Area) -> Callable[[float, float], float]:
    """Return how far a point is from edges and obstacles [m]."""
    return lambda x, y: float(area.clearance(x, y)) + area.margin  # type: ignore[arg-type]


def area_of(asked: InvestigateSettings, scene: SceneSpec) -> Area:
    """Return the area of the settings with what stands in the drawing: boards on their feet, and walls."""
    x, y, half_x, half_y = asked.centre_x, asked.centre_y, 0.5 * asked.width, 0.5 * asked.depth
    discs = [Disc(b.x, b.y, 0.2) for b in scene.boards]
    for wall in scene.walls:
        count = max(int(((wall.x1 - wall.x0) ** 2 + (wall.y1 - wall.y0) ** 2) ** 0.5 / WALL_STEP), 1)
        for k in range(count + 1):
            share = k / count
            discs.append(
                Disc(wall.x0 + share * (wall.x1 - wall.x0), wall.y0 + share * (wall.y1 - wall.y0), 0.02)
            )
    return Area(x - half_x, x + half_x, y - half_y, y + half_y, asked.margin, tuple(discs))
