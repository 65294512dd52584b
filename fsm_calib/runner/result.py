"""What a run found, scored against the world where it is a simulated one: the content of result.json.

`true_*` and the deviations come from the world, for scoring only; nothing here goes back to the robot. A real robot's
result has neither: it tells the predicted error of the camera and k with its standard error.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fsm_calib.actions.notebook import CameraFigures, Notebook
from fsm_calib.errors import DataError
from fsm_calib.journal import plain
from fsm_calib.perception.calibration import FitFigures
from fsm_calib.perception.prediction import projection_difference
from fsm_calib.runner.session import Session
from fsm_calib.types import CameraModel, FloatArray, WheelCalibration
from fsm_calib.world2d.deviation import TEST_COMMAND, TEST_DISTANCE, straight_deviation, straight_track

SLOW = 0.05
"""Speed that a test drive is expected to reach at least [m/s]; it bounds the drive that is drawn."""

LAST_DRIVES = 3
"""Drives at the end whose scatter tells the error of k: as many as must be quiet in a row."""
DRAWN_EVERY = 10
"""Every tenth pose of a test drive is drawn: 0.02 s apart."""


def result_of(session: Session, wall: float, by_part: dict[str, float]) -> dict[str, Any]:
    """Return the content of result.json as plain JSON values.

    Parameters
    ----------
    session : Session
        The finished run.
    wall : float
        Wall time of the run [s].
    by_part : dict
        Wall time of each part [s].
    """
    run = session.run
    failure = run.machine.failure
    result = {
        "outcome": outcome_of(run.machine.state),
        "state": run.machine.state,
        "failure": _failure(failure) if failure else None,
        "scenario": session.scenario.name,
        "robot": session.scenario.robot.name,
        "seed": session.scenario.seed,
        "camera": camera_result(session),
        "wheels": wheels_result(session),
        "exit": exit_result(session),
        "in_lane": lane_result(session),
        "distance_m": distance(session),
        "events": run.sequence,
        "frames": run.robot.frames,
        "seconds": {"simulated": run.robot.now(), "wall": wall, "by_part": by_part},
    }
    if run.lost is not None:
        lost = {"name": type(run.lost).__name__, "reason": f"{run.lost.problem}.", "cure": run.lost.cure}
        result["lost"] = lost
    values: dict[str, Any] = plain(result)
    return values


def outcome_of(state: str) -> str:
    """Return `done`, `aborted`, `failed` or `unfinished`."""
    return state.split("/")[0] if state.split("/")[0] in ("done", "aborted", "failed") else "unfinished"


def _failure(failure: Any) -> dict[str, str]:
    """Return a failure as plain values."""
    return {"name": failure.name, "reason": failure.reason, "cure": failure.cure, "state": failure.state}


def camera_result(session: Session) -> dict[str, Any] | None:
    """Return the camera that the scan found; None when it did not get that far."""
    notebook = session.run.bench.notebook
    camera, figures = notebook.camera, notebook.figures
    if camera is None or figures is None:
        return None
    truth = session.truth
    boards = range(len(session.spec.scene.boards))
    return {
        **fitted_values(camera, figures),
        "predicted_px": figures.predicted_px,
        "expected_px": figures.expected_px,
        "cross_validated_px": figures.cross_validated_px,
        **({} if truth is None else {"true_px": projection_difference(camera, truth.camera).rms}),
        "target_px": figures.target_px,
        "reached": figures.is_reached,
        "weakest_part": figures.weakest,
        "advice": figures.advice,
        "views_used": figures.views_used,
        "views_refused": notebook.views_refused,
        "views_per_board": [figures.views_per_board.get(str(board), 0) for board in boards],
    }


def fitted_values(camera: CameraModel, figures: CameraFigures | FitFigures) -> dict[str, Any]:
    """Return a fitted camera and its reprojection figures [px] as plain values."""
    return {
        "model": camera.model,
        "matrix": camera.matrix.tolist(),
        "distortion": camera.distortion.tolist(),
        "rms_px": figures.rms_px,
        "mean_px": figures.mean_px,
        "paper_px": figures.paper_px,
    }


def wheels_result(session: Session) -> dict[str, Any] | None:
    """Return what the wheel iteration found; None when it did not run."""
    notebook = session.run.bench.notebook
    if not notebook.runs:
        return None
    ratio = ratio_before_lane(notebook)
    return {
        "wheel_ratio": ratio,
        **true_ratio(session),
        "iterations": len(notebook.runs),
        "deviation_2m_m": deviation(session, ratio),
    }


def true_ratio(session: Session) -> dict[str, float]:
    """Return the true k of a simulated robot; of a real one, the standard error of the k found [1], where it can
    be told: that of the mean of the quiet drives at the end.
    """
    if session.truth is not None:
        return {"true_wheel_ratio": session.truth.wheel_ratio}
    last = [run.wheel_ratio + run.k_i - 1.0 for run in session.run.bench.notebook.runs[-LAST_DRIVES:]]
    if len(last) < LAST_DRIVES:
        return {}
    return {"wheel_ratio_error": float(np.std(last, ddof=1) / math.sqrt(len(last)))}


def distance(session: Session) -> float:
    """Return the path of the axle's centre [m]: true, or dead-reckoned for a real robot."""
    if session.truth is not None:
        return session.truth.odometer
    return float(np.linalg.norm(np.diff(session.connection.track()[:, 1:3], axis=0), axis=1).sum())


def ratio_before_lane(notebook: Notebook) -> float:
    """Return k as it was when the lane phase began, or as it is when there was none."""
    return notebook.wheel_ratio if notebook.lane_before is None else notebook.lane_before


def lane_result(session: Session) -> dict[str, Any] | None:
    """Return what the refinement in the lane changed; None when it did not begin."""
    notebook = session.run.bench.notebook
    truth = session.truth
    if notebook.lane_before is None:
        return None
    return {
        "wheel_ratio_before": notebook.lane_before,
        "wheel_ratio_after": notebook.wheel_ratio,
        "applied": notebook.wheel_ratio != notebook.lane_before,
        **({} if truth is None else {"true_wheel_ratio": truth.wheel_ratio}),
        "markers": len(notebook.lane_runs),
        "deviation_before_m": deviation(session, notebook.lane_before),
        "deviation_after_m": deviation(session, notebook.wheel_ratio),
    }


def exit_result(session: Session) -> dict[str, Any] | None:
    """Return whether the robot left the field; None when the phase was not planned."""
    if "exit" not in session.scenario.plan:
        return None
    machine = session.run.machine
    left = machine.state == "done" or (machine.books.phase == "lane" and "lane" in session.scenario.plan)
    return {"handed_over": left}


def deviation(session: Session, ratio: float) -> float | None:
    """Return the deviation after 2 m [m], right positive, as the robot is now; None without a drive, and
    for a real robot.
    """
    if session.truth is None:
        return None
    try:
        return straight_deviation(session.truth.parameters, ratio)
    except DataError:
        return None


def test_drives(session: Session) -> dict[str, FloatArray]:
    """Return the paths of 2 m test drives, shape (n, 2) [m]: uncalibrated, calibrated, and after the lane.

    A real robot has none: nobody knows its truth.
    """
    notebook = session.run.bench.notebook
    if session.truth is None:
        return {}
    drives = {"before": notebook.ratio_history[0]}
    if notebook.runs:
        drives["after"] = ratio_before_lane(notebook)
    if notebook.lane_before is not None:
        drives["after lane"] = notebook.wheel_ratio
    parameters = session.truth.parameters
    return {name: test_path(parameters, ratio) for name, ratio in drives.items()}


def test_path(parameters: FloatArray, ratio: float) -> FloatArray:
    """Return the path of a 2 m drive with wheel ratio `ratio`, shape (n, 2) [m]."""
    track = straight_track(parameters, (TEST_COMMAND, ratio * TEST_COMMAND), TEST_DISTANCE / SLOW)[
        ::DRAWN_EVERY, :2
    ]
    driven = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(track, axis=0), axis=1))])
    return track[driven <= TEST_DISTANCE]


def calibration_of(notebook: Notebook) -> WheelCalibration:
    """Return the wheel calibration for Duckietown's file: gain 1, trim from the final k."""
    return WheelCalibration(wheel_ratio=notebook.wheel_ratio)
