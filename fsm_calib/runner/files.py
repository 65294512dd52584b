"""Writes what a run leaves behind: result.json, Duckietown's calibration files, the recording, the report."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from fsm_calib.calibration_files import write_kinematics
from fsm_calib.errors import DataError
from fsm_calib.journal import JOURNAL_NAME, read_journal, write_atomically
from fsm_calib.perception.calibration import CameraCalibration
from fsm_calib.perception.camera_files import write_extrinsics, write_intrinsics
from fsm_calib.perception.extrinsics import floor_homography, is_corrupt, rectified_matrix
from fsm_calib.perception.static_boards import calibrate_scan
from fsm_calib.runner.record import RunRecord
from fsm_calib.runner.result import calibration_of, test_drives
from fsm_calib.runner.session import Session
from fsm_calib.scenario.models import Scenario
from fsm_calib.world2d.robot import WorldSpec

RESULT_NAME = "result.json"
REPORT_NAME = "report.html"
Draw = Callable[[RunRecord], str]
"""Makes a page of a finished run; the runner knows nobody who does."""


def write_result(directory: Path, result: Mapping[str, Any]) -> Path:
    """Write result.json and return its path."""
    path = directory / RESULT_NAME
    write_atomically(path, (json.dumps(result, indent=2, ensure_ascii=False) + "\n").encode())
    return path


def write_calibrations(directory: Path, session: Session) -> list[Path]:
    """Write Duckietown's files for what was found, below ``calibrations/``, and return their paths.

    A wheel iteration that did not come to its end leaves no file: its k is nobody's. A mount that Duckietown
    would refuse as corrupt leaves none either.
    """
    notebook, name = session.run.bench.notebook, session.scenario.robot.name
    folder, now = directory / "calibrations", datetime.now(UTC)
    remarks = provenance(session)
    written = []
    if (notebook.runs or notebook.lane_runs) and session.run.machine.books.phase != "wheels":
        written.append(write_kinematics(folder, name, calibration_of(notebook), now, remarks))
    if notebook.camera is not None and notebook.figures is not None:
        path = folder / "camera_intrinsic" / f"{name}.yaml"
        written.append(write_intrinsics(path, notebook.camera, name, remarks))
        homography = floor_homography(notebook.mount, rectified_matrix(notebook.camera))
        path = folder / "camera_extrinsic" / f"{name}.yaml"
        if not is_corrupt(homography):
            written.append(write_extrinsics(path, homography, now.strftime("%Y-%m-%d")))
    return written


def provenance(session: Session) -> str:
    """Return where a calibration comes from, for the head of its file."""
    scenario, notebook = session.scenario, session.run.bench.notebook
    lines = [f"fsm-calib {version('fsm-calib')}, scenario {scenario.name}, seed {scenario.seed}"]
    if notebook.figures is not None:
        lines.append(f"camera: rms {notebook.figures.rms_px:.3f} px, {notebook.figures.views_used} views")
    if notebook.runs:
        lines.append(f"wheels: wheel ratio {notebook.wheel_ratio:.5f} from {len(notebook.runs)} drives")
    return "\n".join(lines)


def record_of(directory: Path, session: Session, result: Mapping[str, Any]) -> RunRecord:
    """Return everything the report is made of."""
    return RunRecord(
        directory=directory,
        scenario=session.scenario,
        scene=session.spec.scene,
        board=session.settings.board,
        result=result,
        events=list(read_journal(directory / JOURNAL_NAME)),
        notebook=session.run.bench.notebook,
        calibration=session.run.bench.calibration or _solved_again(session),
        pictures=session.run.gallery.pictures,
        settings=settings_of(session),
        track=session.connection.track(),
        paths=test_drives(session),
    )


def _solved_again(session: Session) -> CameraCalibration | None:
    """Return the camera's solution of a run that went on after it: the same views give it again."""
    notebook = session.run.bench.notebook
    if notebook.camera is None or notebook.figures is None:
        return None
    try:
        return calibrate_scan(notebook.views, session.settings.board, notebook.image_size).calibration
    except DataError:
        return None


def settings_of(session: Session) -> dict[str, Any]:
    """Return every setting of the run, by group."""
    spec, world = session.spec, session.world
    simulation = {} if world is None else _simulation(spec)
    return {
        "scenario": session.scenario.model_dump(include={"name", "seed", "plan", "published", "output"}),
        "robot": _simulated_robot(spec) if world else _real_robot(session.scenario),
        "scene": spec.scene,
        **simulation,
        "limits": session.limits,
        "actions": session.settings,
    }


def _simulated_robot(spec: WorldSpec) -> dict[str, Any]:
    """Return the settings of a simulated robot."""
    return {
        "name": spec.robot.name,
        "wheel_ratio": spec.robot.wheel_ratio,
        "speed": spec.robot.speed,
        "axle_length": spec.robot.axle_length,
        "defocus": spec.robot.defocus,
        "mount": spec.robot.mount,
        "effects": dict(spec.robot.effects),
    }


def _real_robot(scenario: Scenario) -> dict[str, Any]:
    """Return the settings of a real robot: where it is reached, and its link."""
    return scenario.robot.model_dump(include={"name", "connect", "vehicle", "host", "port", "link"})


def _simulation(spec: WorldSpec) -> dict[str, Any]:
    """Return the settings that only a simulation has."""
    faults = {str(number): fault for number, fault in enumerate(spec.faults)}
    return {"world": spec.settings, "sensor": spec.optics, "wear": spec.wear, "faults": faults}


def write_report(directory: Path, session: Session, result: Mapping[str, Any], draw: Draw) -> Path:
    """Write the page that `draw` makes of the run, report.html, and return its path."""
    path = directory / REPORT_NAME
    write_atomically(path, draw(record_of(directory, session, result)).encode())
    return path
