"""Runs an investigation from its beginning, or from where it was killed, to its files."""

from __future__ import annotations

import json
import math
import shutil
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fsm_calib.diagnosis.design.belief import Belief
from fsm_calib.diagnosis.design.designer import design
from fsm_calib.journal import write_atomically
from fsm_calib.outcome import Outcome
from fsm_calib.recording.recording import Recording
from fsm_calib.recording.writers import write_recording
from fsm_calib.runner.hold import held
from fsm_calib.runner.investigation.files import DRIVES, OWN_FILES, OWN_FOLDERS, RESULT
from fsm_calib.runner.investigation.session import Before, Investigation, session
from fsm_calib.runner.investigation.thinking import Designer
from fsm_calib.runner.loop import run_to_end, step_abort
from fsm_calib.runner.progress import Observer, Silent
from fsm_calib.runner.run import Stopped, clear, stop_on_signals
from fsm_calib.scenario.models import Scenario

WORTH_TELLING = 0.01
"""Probability from which on an effect that may hide is told."""


def investigate(
    scenario: Scenario,
    directory: Path,
    *,
    given: Sequence[Recording] = (),
    calibration: Path | None = None,
    resume: bool = False,
    observer: Observer | None = None,
    designer: Designer = design,
) -> tuple[Investigation, dict[str, Any]]:
    """Investigate a scenario's robot; write its files and return the investigation with its result.

    Parameters
    ----------
    given : recordings of the robot that were there before.
    calibration : where an earlier run wrote the calibration of the robot's camera.
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
        before = Before(tuple(given), calibration)
        return _investigated(scenario, directory, before, resume, observer or Silent(), designer)


def _investigated(
    scenario: Scenario,
    directory: Path,
    before: Before,
    resume: bool,
    observer: Observer,
    designer: Designer,
) -> tuple[Investigation, dict[str, Any]]:
    """Investigate in a directory that no other run works in."""
    began = time.perf_counter()
    going = session(scenario, directory, before, resume, observer, designer)
    with stop_on_signals():
        try:
            run_to_end(going.run)
        except Stopped as stopped:
            step_abort(going.run, Outcome("abort", {}, str(stopped)))
        finally:
            going.run.journal.close()
            going.connection.close()
    going.mind.recall(going.bench)
    result = result_of(going, time.perf_counter() - began)
    write_atomically(directory / RESULT, (json.dumps(result, indent=1) + "\n").encode())
    for number, recording in enumerate(going.mind.recordings(going.bench)[len(before.recordings) :], 1):
        write_recording(recording, directory / DRIVES / f"drive-{number:02d}")
    return going, result


def _why_ended(going: Investigation, verdict: dict[str, Any]) -> dict[str, str]:
    """Return reason and cure: of what ended the run, or the verdict's own reason where it came to its end."""
    machine, lost, belief = going.run.machine, going.run.lost, going.mind.belief
    failure, state = machine.failure, machine.state
    if failure is not None:
        nothing = belief is not None and not belief.leader.names and verdict.get("verdict") == "match"
        found = f"{nothing_found(belief)} " if nothing and belief is not None else ""
        return {"reason": found + failure.reason, "cure": failure.cure}
    if lost is not None:
        return {"reason": f"{lost.problem}.", "cure": f"{lost.cure} Go on with --resume."}
    if state == "aborted":
        return {"reason": "The investigation was stopped.", "cure": "Go on with --resume."}
    return {"reason": verdict.get("reason", ""), "cure": ""}


def nothing_found(belief: Belief) -> str:
    """Return in a sentence how sure it is that nothing is missing, and what may hide after all."""
    hidden = [
        f"{h.label} {100.0 * p:.0f} %"
        for h, p in zip(belief.hypotheses, belief.probabilities * (1.0 - belief.unnamed), strict=True)
        if h.names and p >= WORTH_TELLING
    ]
    beside = f" What may hide: {', '.join(hidden)}." if hidden else ""
    return f"Nothing that matters is missing, {math.floor(100.0 * belief.sureness)} % sure.{beside}"


def result_of(going: Investigation, wall: float) -> dict[str, Any]:
    """Return the content of investigation.json: the diagnosis' own, with the drives, how it ended, and what it cost."""
    findings, machine = going.bench.findings, going.run.machine
    verdict = going.mind.diagnosis.verdict.as_json() if going.mind.diagnosis is not None else {}
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
        **_why_ended(going, verdict),
        "sureness": None if going.mind.belief is None else round(going.mind.belief.sureness, 4),
        "robot": {"seconds": round(findings.spent, 3), "distance_m": round(findings.distance, 3)},
        "seconds": round(wall, 2),
    }
