"""Runs an investigation from its beginning, or from where it was killed, to its files."""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fsm_calib.actions.investigating import ACTIVITIES, InvestigationBench
from fsm_calib.diagnosis.design.area import Area, Disc
from fsm_calib.diagnosis.design.designer import design
from fsm_calib.errors import InputError
from fsm_calib.journal import Journal, read_checkpoint, write_atomically
from fsm_calib.machines.investigate import INVESTIGATE
from fsm_calib.outcome import Outcome
from fsm_calib.recording.recording import Recording, RobotFacts
from fsm_calib.recording.writers import write_recording
from fsm_calib.robots.connection import Connection
from fsm_calib.runner.connecting import connect, drive_again
from fsm_calib.runner.gallery import Gallery
from fsm_calib.runner.hold import held
from fsm_calib.runner.investigation.files import DRIVES, OWN_FILES, OWN_FOLDERS, RESULT
from fsm_calib.runner.investigation.own_camera import tracker_of, with_sight
from fsm_calib.runner.investigation.thinking import Designer, Mind, with_facts
from fsm_calib.runner.knowledge import teach
from fsm_calib.runner.logged import LoggedRobot
from fsm_calib.runner.loop import Run, run_to_end, step_abort
from fsm_calib.runner.parts import Parts
from fsm_calib.runner.progress import Observer, Silent
from fsm_calib.runner.run import Stopped, clear, stop_on_signals
from fsm_calib.runner.session import check_same, identity
from fsm_calib.scenario.models import Scenario
from fsm_calib.scenario.world import world_of
from fsm_calib.statechart.runtime import Failure, Machine
from fsm_calib.types import WheelCalibration
from fsm_calib.world2d.overhead import OverheadTracker
from fsm_calib.world2d.scene import SceneSpec

WALL_STEP = 0.1  # m between the discs that stand for a wall


@dataclass(frozen=True, eq=False)
class Investigation:
    """An investigation while it runs: the loop's run, what it thinks, where it may drive."""

    scenario: Scenario
    run: Run
    bench: InvestigationBench
    mind: Mind
    connection: Connection


def investigate(
    scenario: Scenario,
    directory: Path,
    *,
    given: Sequence[Recording] = (),
    resume: bool = False,
    observer: Observer | None = None,
    designer: Designer = design,
) -> tuple[Investigation, dict[str, Any]]:
    """Investigate a scenario's robot; write its files and return the investigation with its result.

    Parameters
    ----------
    given : recordings of the robot that were there before.
    resume : go on after the last whole event of the investigation in `directory`.
    designer : who plans drives; benchmarks put others in its place.

    Raises
    ------
    InputError
        The scenario cannot be built, or its robot has no tracker.
    DataError
        The run to go on from belongs to another scenario, or its journal is damaged.
    """
    if not resume:
        directory.mkdir(parents=True, exist_ok=True)
    with held(directory):
        if not resume:
            clear(directory)
            for name in OWN_FILES:
                (directory / name).unlink(missing_ok=True)
            for name in OWN_FOLDERS:
                shutil.rmtree(directory / name, ignore_errors=True)
        return _investigated(scenario, directory, tuple(given), resume, observer or Silent(), designer)


def _investigated(
    scenario: Scenario,
    directory: Path,
    given: tuple[Recording, ...],
    resume: bool,
    observer: Observer,
    designer: Designer,
) -> tuple[Investigation, dict[str, Any]]:
    """Investigate in a directory that no other run works in."""
    began = time.perf_counter()
    going = session(scenario, directory, given, resume, observer, designer)
    with stop_on_signals():
        try:
            run_to_end(going.run)
        except Stopped as stopped:
            step_abort(going.run, Outcome("abort", {}, str(stopped)))
        finally:
            going.run.journal.close()
            going.connection.close()
    result = result_of(going, time.perf_counter() - began)
    write_atomically(directory / RESULT, (json.dumps(result, indent=1) + "\n").encode())
    for number, recording in enumerate(going.mind.recordings(going.bench)[len(given) :], 1):
        write_recording(recording, directory / DRIVES / f"drive-{number:02d}")
    return going, result


def session(
    scenario: Scenario,
    directory: Path,
    given: Sequence[Recording],
    resume: bool,
    observer: Observer,
    designer: Designer,
) -> Investigation:
    """Build an investigation, new or from its checkpoint."""
    spec, asked = world_of(scenario), scenario.investigate.build()
    state = read_checkpoint(directory) if resume else None
    heading = identity(scenario, INVESTIGATE)
    if state is not None:
        check_same(state, heading, directory)
    parts = Parts("start")
    connection = connect(scenario, spec)
    robot = LoggedRobot(connection.robot, parts, state["frames"] if state else 0)
    bench = InvestigationBench(robot, asked=asked)
    area = area_of(asked, spec.scene)
    bench.clearance = _clearance(area)
    teach(bench.notebook, scenario, spec.robot)
    if asked.poses == "camera":
        bench.tracker = tracker_of(bench, spec.scene, asked)
        area = with_sight(area, bench, spec.scene, asked)
    else:
        bench.tracker = _overhead(connection, scenario)
    scene = spec.scene if asked.poses == "camera" else None
    mind = Mind(area, with_facts(_facts(scenario), given), scenario.seed, tuple(given), designer, scene)
    run = Run(
        machine=_machine(state),
        bench=bench,
        robot=robot,
        journal=Journal(directory, state["journal_length"], state["journal_chain"])
        if state
        else Journal(directory),
        activities=_activities(mind),
        pose=connection.pose,
        parts=parts,
        observer=observer,
        gallery=Gallery.from_state(directory, 1, []),
        heading=heading,
    )
    if state is not None:
        run.sequence = state["sequence"]
        bench.from_state(state["bench"])
        if connection.world is not None:
            drive_again(connection, connection.world, directory, state)
        if isinstance(bench.tracker, OverheadTracker):
            bench.tracker.skip(run.robot.now())
    return Investigation(scenario, run, bench, mind, connection)


def _overhead(connection: Connection, scenario: Scenario) -> OverheadTracker:
    if connection.world is None:
        raise InputError(
            "no tracker of ours stands over this robot",
            where="investigate.poses",
            cure="Take `poses: camera` over floor markers, or drive it with `fsm-calib diagnose --plan`.",
        )
    return OverheadTracker(connection.world, scenario.tracker.build())


def _machine(state: dict[str, Any] | None) -> Machine:
    if state is None:
        return Machine(INVESTIGATE)
    return Machine(INVESTIGATE, books=INVESTIGATE.books.from_dict(state["books"]), state=state["state"])


def _activities(mind: Mind) -> dict[str, Callable[[Any], Outcome]]:
    thought = (mind.design_drive, mind.diagnose_drives, mind.judge_answer)
    return {**ACTIVITIES, **{activity.__name__: activity for activity in thought}}


def _facts(scenario: Scenario) -> RobotFacts:
    nominal = WheelCalibration()
    return RobotFacts(scenario.robot.name, nominal.wheel_radius, nominal.axle_length, max_wheel_rate=20.0)


def _clearance(area: Area) -> Callable[[float, float], float]:
    """Return how far a point is from edges and obstacles [m]."""
    return lambda x, y: float(area.clearance(x, y)) + area.margin  # type: ignore[arg-type]


def area_of(asked: Any, scene: SceneSpec) -> Area:
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


def _why_ended(failure: Failure | None, state: str, verdict: dict[str, Any]) -> dict[str, str]:
    """Return reason and cure: of what ended the run, or the verdict's own reason where it came to its end."""
    if failure is not None:
        return {"reason": failure.reason, "cure": failure.cure}
    if state == "aborted":
        return {"reason": "The investigation was stopped.", "cure": "Go on with --resume."}
    return {"reason": verdict.get("reason", ""), "cure": ""}


def result_of(going: Investigation, wall: float) -> dict[str, Any]:
    """Return the content of investigation.json: the diagnosis' own, with the drives, how it ended, and what it cost."""
    findings, machine = going.bench.findings, going.run.machine
    verdict = going.mind.diagnosis.verdict.as_json() if going.mind.diagnosis is not None else {}
    failure = machine.failure
    drives = [
        {
            "seconds": round(d.poses[-1][0] - d.poses[0][0], 2),
            "why": d.plan.get("why", ""),
            "expected": d.plan.get("expected"),
            "reached": None if d.reached is None else round(d.reached, 4),
            "cut": d.cut,
            "beliefs": [[name, round(p, 4)] for name, p in d.beliefs],
        }
        for d in findings.drives
    ]
    return {
        **verdict,
        "drives": drives,
        "ended": machine.state,
        **_why_ended(failure, machine.state, verdict),
        "sureness": None if going.mind.belief is None else round(going.mind.belief.sureness, 4),
        "robot": {"seconds": going.run.robot.now(), "distance_m": round(findings.distance, 3)},
        "seconds": round(wall, 2),
    }
