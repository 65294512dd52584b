"""Runs a scenario from its beginning, or from where it was killed, to its files."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fsm_calib.errors import RobotLost
from fsm_calib.journal import CHECKPOINT_NAME, JOURNAL_NAME, PREVIOUS_NAME, plain
from fsm_calib.machines.calibration import CALIBRATION
from fsm_calib.outcome import Outcome
from fsm_calib.perception.opencv_time import watched
from fsm_calib.runner import files
from fsm_calib.runner.hold import held
from fsm_calib.runner.loop import run_to_end, step_abort
from fsm_calib.runner.parts import Parts
from fsm_calib.runner.progress import Observer, Silent
from fsm_calib.runner.recording import write_drive
from fsm_calib.runner.result import calibration_of, result_of
from fsm_calib.runner.session import Session, new_session, resumed_session
from fsm_calib.scenario.models import Scenario
from fsm_calib.statechart.machinery import Machinery
from fsm_calib.statechart.validate import check
from fsm_calib.stops import on_stop_signals

RUN_FILES = (JOURNAL_NAME, CHECKPOINT_NAME, PREVIOUS_NAME, files.RESULT_NAME, files.REPORT_NAME)
RUN_FOLDERS = ("frames", "calibrations", "recording")


class Stopped(Exception):
    """The operator or the system asked the program to stop."""


@dataclass(frozen=True, eq=False)
class Finished:
    """A run that has ended: its directory, its session and the content of result.json."""

    directory: Path
    session: Session
    result: dict[str, Any]


def run_scenario(
    scenario: Scenario,
    directory: Path,
    *,
    resume: bool = False,
    observer: Observer | None = None,
    machinery: Machinery = CALIBRATION,
    draw: files.Draw | None = None,
) -> Finished:
    """Run a scenario and write its files.

    Parameters
    ----------
    scenario : Scenario
        What to do.
    directory : Path
        Where the files go; made when it is missing. Files of an earlier run are replaced unless `resume`.
    resume : bool
        Go on after the last whole event of the run in `directory`.
    observer : Observer or None
        Who watches.
    machinery : Machinery
        The machine that runs; the calibration by default.
    draw : callable or None
        Makes the page of a finished run, `report.html`; None for no page.

    Raises
    ------
    InputError
        The scenario cannot be built, the machine's tables are not sound (nothing is written then), or another run is
        at work in the directory.
    DataError
        The run to go on from belongs to another scenario, or its journal is damaged.
    """
    check(machinery)
    if not resume:
        directory.mkdir(parents=True, exist_ok=True)
    with held(directory):
        if not resume:
            clear(directory)
        start = resumed_session if resume else new_session
        return _run_held(scenario, directory, start, observer or Silent(), machinery, draw)


def _run_held(
    scenario: Scenario,
    directory: Path,
    start: Callable[..., Session],
    observer: Observer,
    machinery: Machinery,
    draw: files.Draw | None,
) -> Finished:
    """Run a scenario in a directory that no other run works in."""
    parts = Parts("start")
    began = time.perf_counter()
    with watched(lambda: parts.enter("opencv"), parts.leave):
        session = start(scenario, directory, parts, observer, machinery)
        try:
            with stop_on_signals():
                drive(session)
                stored = store_on_robot(session)
        finally:
            session.connection.close()
        with parts.part("report"):
            result = result_of(session, 0.0, {})
            if session.world is None:
                result["stored"] = stored
            if result["in_lane"]:
                result["in_lane"] |= _doubt(session, directory)
            files.write_calibrations(directory, session)
            if scenario.output.recording:
                write_drive(directory, session)
            if scenario.output.report and draw is not None:
                files.write_report(directory, session, result | _seconds(session, parts, began), draw)
    result |= _seconds(session, parts, began)
    files.write_result(directory, result)
    return Finished(directory, session, result)


def _doubt(session: Session, directory: Path) -> dict[str, Any]:
    """Return what the lane's drives leave open, for result.json; empty where that is nothing."""
    from fsm_calib.runner.lane_doubt import lane_doubt  # brings the diagnosis, which no other phase needs

    found = lane_doubt(session, directory)
    return {} if found is None else {"doubt": plain(found.as_json())}


def store_on_robot(session: Session) -> list[str]:
    """Store a finished calibration on a real robot and return what was stored, or why not, a sentence each."""
    notebook, machine = session.run.bench.notebook, session.run.machine
    if session.world is not None or machine.state != "done":
        return []
    camera = notebook.camera if notebook.figures is not None else None
    wheels = calibration_of(notebook) if notebook.runs or notebook.lane_runs else None
    try:
        return session.connection.store(camera, wheels)
    except RobotLost as lost:
        return [f"Not everything was stored on the robot: {lost}"]


def drive(session: Session) -> None:
    """Run the machine to its end; a request to stop takes it to `aborted`. Wheels end at zero."""
    try:
        run_to_end(session.run)
    except Stopped as stopped:
        step_abort(session.run, Outcome("abort", {}, str(stopped)))
    finally:
        session.run.journal.close()


def _seconds(session: Session, parts: Parts, began: float) -> dict[str, Any]:
    """Return the `seconds` of result.json."""
    by_part = {name: round(value, 4) for name, value in parts.seconds().items()}
    wall = round(time.perf_counter() - began, 4)
    return {"seconds": {"simulated": session.run.robot.now(), "wall": wall, "by_part": by_part}}


def clear(directory: Path) -> None:
    """Remove what an earlier run left in the directory; other files stay."""
    for name in RUN_FILES:
        (directory / name).unlink(missing_ok=True)
    for name in RUN_FOLDERS:
        shutil.rmtree(directory / name, ignore_errors=True)


def stop_on_signals() -> AbstractContextManager[None]:
    """Turn stop signals into `Stopped` inside the `with` block (in the main thread)."""
    return on_stop_signals(lambda name: Stopped(f"Stopped by {name}."))
