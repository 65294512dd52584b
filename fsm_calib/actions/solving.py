"""Solve the camera from the views kept so far, and go to another standpoint when they do not suffice."""

from __future__ import annotations

import math
from dataclasses import replace

from fsm_calib.actions.bench import Bench
from fsm_calib.actions.judging import stop_rule
from fsm_calib.actions.moving import drive
from fsm_calib.actions.notebook import CameraFigures
from fsm_calib.errors import DataError
from fsm_calib.outcome import Outcome
from fsm_calib.perception.calibration import CameraCalibration
from fsm_calib.perception.information import advice, weakest_region
from fsm_calib.perception.static_boards import StaticResult, calibrate_scan


def solve_camera(bench: Bench) -> Outcome:
    """Compute the intrinsics; solved, imprecise or refused, with the figures and the reason."""
    notebook = bench.notebook
    try:
        scan = calibrate_scan(notebook.views, bench.settings.board, notebook.image_size)
    except DataError as error:
        return _refused(error.problem, error.cure)
    result = scan.calibration
    if result.refused:
        return _refused(result.reason, "Lean a board or lay one on the floor, and check the lens.")
    rule = stop_rule(bench.settings.camera)
    is_reached = result.predicted_px <= rule.predicted_px
    cure = "" if is_reached else advice(result.predicted_map, rule)
    _keep(bench, result, cure)
    _keep_mount(bench, scan)
    evidence = {
        "predicted_px": result.predicted_px,
        "rms_px": result.rms_px,
        "views": result.views_used,
        "views_refused": notebook.views_refused,
    }
    asked = f"{rule.predicted_px:.3g} px asked for" + ("" if is_reached else ": not reached")
    sentence = f"{result.views_used} views: {result.predicted_px:.3f} px predicted error, {asked}."
    return Outcome("camera_solved" if is_reached else "camera_imprecise", evidence, sentence, cure)


def move_to_standpoint(bench: Bench) -> Outcome:
    """Drive back a short way, so that the boards are seen from elsewhere."""
    settings = bench.settings
    speed = bench.notebook.speed or settings.drive.expected_speed
    drive(bench, settings.camera.standpoint_move / speed, bench.notebook.wheel_ratio, backward=True)
    bench.notebook.board_azimuth, bench.notebook.panorama = None, None
    return Outcome("standpoint_reached", sentence="The robot stands at another place.")


def _keep(bench: Bench, result: CameraCalibration, cure: str) -> None:
    notebook = bench.notebook
    notebook.camera, bench.calibration = result.camera, result
    validated = result.cross_validated_px
    seen = {str(board): count for board, count in enumerate(result.views_per_board) if count}
    notebook.figures = CameraFigures(
        rms_px=result.rms_px,
        mean_px=result.mean_px,
        paper_px=result.paper_px,
        predicted_px=result.predicted_px,
        cross_validated_px=None if math.isnan(validated) else validated,
        views_used=result.views_used,
        views_per_board=seen,
        reason=result.reason,
        expected_px=result.predicted_map.expected,
        target_px=bench.settings.camera.target_px,
        weakest=weakest_region(result.predicted_map),
        advice=cure,
    )


def _keep_mount(bench: Bench, scan: StaticResult) -> None:
    """Take pitch and roll from the boards that stood still, and the height when one of them lay on the
    floor.
    """
    if not scan.is_static:
        return
    notebook, flat = bench.notebook, math.isfinite(scan.height)
    height = scan.height if flat else notebook.mount.height
    notebook.mount = replace(notebook.mount, pitch=scan.pitch, roll=scan.roll, height=height)
    notebook.mount_known = "all" if flat else "tilt"


def _refused(reason: str, cure: str) -> Outcome:
    return Outcome("camera_refused", {"reason": reason}, f"The camera cannot be solved: {reason}.", cure)
