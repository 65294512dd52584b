"""Everything one robot of a study goes through: by hand, test 1, test 2. Each part is a stage that can be resumed.

Random streams are made of the robot's seed and the part's number, so that leaving one part out changes
nothing in the others. The world's truth is read for scoring, and by the operator's tape measure.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from fsm_calib.errors import DataError
from fsm_calib.perception.calibration import CameraCalibration, FitFigures
from fsm_calib.perception.prediction import projection_difference
from fsm_calib.runner.parts import Parts
from fsm_calib.runner.progress import Silent
from fsm_calib.runner.result import fitted_values, result_of
from fsm_calib.runner.run import drive
from fsm_calib.runner.session import Session, resumed_session
from fsm_calib.scenario.models import Scenario
from fsm_calib.scenario.world import world_of
from fsm_calib.study.hand_camera import calibrate_by_hand, mount_by_hand
from fsm_calib.study.hand_wheels import HandWheels, calibrate_wheels_by_hand
from fsm_calib.study.held_board import HandWork
from fsm_calib.study.models import Study
from fsm_calib.study.operator import OperatorSettings
from fsm_calib.study.stages import Stages
from fsm_calib.study.variants import BASE, Variant, scenario_of_robot
from fsm_calib.types import BoardSpec, CameraModel, CameraMount
from fsm_calib.world2d.deviation import straight_deviation
from fsm_calib.world2d.robot import WorldSpec

_HAND_STREAM, _WHEELS_STREAM, _MOUNT_STREAM = 101, 102, 103
PLAN_TEST_1 = ("orientation", "wheels")
"""Phases of test 1, in which the camera is known."""
KEPT_RESULTS = ("outcome", "state", "failure", "camera", "wheels", "exit", "in_lane", "frames")
"""What a row keeps of the result of a run (`runner.result`)."""
VIEW_SECONDS, DRIVE_SECONDS = 4.0, 30.0
"""What a person needs for one view of the board, and for fetching the robot and typing trim [s]: assumed."""


def run_trial(study: Study, variant: Variant, robot: int, directory: Path) -> dict[str, Any]:
    """Run one robot of one variant and return its row of results: plain JSON values.

    All of it follows from study, variant and number, but for `cost`: wall and processor time of the parts.

    Parameters
    ----------
    study : Study
    variant : Variant
    robot : int
        Number of the robot.
    directory : Path
        The robot's working directory; finished stages in it are taken as they are.
    """
    scenario = scenario_of_robot(study, variant, robot)
    spec = world_of(scenario)
    stages = Stages(directory, {})
    row: dict[str, Any] = {"variant": variant.name, "robot": robot, "seed": scenario.seed}
    row["truth"] = {"wheel_ratio": spec.robot.wheel_ratio, "pitch": spec.robot.mount.pitch}
    parts = study.parts if variant.name == BASE else ("test_2",)
    operator: OperatorSettings = study.operator.build()
    if "by_hand" in parts or "test_1" in parts:
        board = scenario.scene.boards.board.build()
        row["by_hand"] = stages.run("by_hand", lambda: by_hand(spec, operator, board))
    if "test_1" in parts:
        known = row["by_hand"]["best"]
        row["test_1"] = stages.run("test_1", lambda: test_1(scenario, known, directory / "test_1"))
    if "test_2" in parts:
        row["test_2"] = stages.run("test_2", lambda: automatic(scenario, directory / "test_2"))
    return row | {"cost": stages.cost}


def by_hand(spec: WorldSpec, operator: OperatorSettings, board: BoardSpec) -> dict[str, Any]:
    """Return what a person makes of the robot: the first camera calibration, the best one, the wheels.

    Errors of a person who does not find the board are data: the camera is then null.
    """
    cameras = [hand_camera(spec, operator, board, repeat) for repeat in range(operator.references)]
    wheels = calibrate_wheels_by_hand(
        spec.robot, spec.settings, operator, np.random.default_rng([spec.seed, _WHEELS_STREAM])
    )
    usable = [camera for camera in cameras if camera is not None]
    best = min(usable, key=lambda camera: camera["paper_px"]) if usable else None
    seconds = {"camera": VIEW_SECONDS * (cameras[0] or {}).get("attempts", 0)}
    seconds["wheels"] = wheels.seconds + DRIVE_SECONDS * len(wheels.drives)
    return {
        "camera": cameras[0],
        "best": best,
        "wheels": wheels_row(wheels, spec),
        "seconds": seconds,
    }


def hand_camera(
    spec: WorldSpec, operator: OperatorSettings, board: BoardSpec, repeat: int
) -> dict[str, Any] | None:
    """Return calibration number `repeat` by hand as plain values, with the mount; None when it failed.

    `same_solver` holds what the robot's own code makes of the same pictures.
    """
    work = HandWork(spec.robot, spec.optics, operator, board)
    try:
        hand = calibrate_by_hand(work, np.random.default_rng([spec.seed, _HAND_STREAM, repeat]))
    except DataError:
        return None
    true, camera = spec.robot.camera, hand.manual.camera
    row = camera_row(camera, hand.manual.figures, true) | {"attempts": hand.attempts}
    own = hand.same_solver
    row["same_solver"] = None if own is None else _own_row(own, true)
    rng = np.random.default_rng([spec.seed, _MOUNT_STREAM, repeat])
    return row | {"mount": _mount_row(work, camera, rng)}


def _mount_row(work: HandWork, camera: CameraModel, rng: np.random.Generator) -> dict[str, float] | None:
    """Return the mount by hand as plain values; None when the floor board was not read."""
    try:
        return asdict(mount_by_hand(work, camera, rng))
    except DataError:
        return None


def camera_row(camera: CameraModel, figures: FitFigures, true: CameraModel) -> dict[str, Any]:
    """Return a calibration's reprojection figures [px] and its error against the true lens [px]."""
    return {
        **fitted_values(camera, figures),
        "true_px": projection_difference(camera, true).rms,
    }


def _own_row(calibration: CameraCalibration, true: CameraModel) -> dict[str, Any]:
    """Return what the robot's own code made of a person's pictures."""
    figures = FitFigures(calibration.rms_px, calibration.mean_px, calibration.paper_px)
    extra = {"predicted_px": calibration.predicted_px, "views_used": calibration.views_used}
    return camera_row(calibration.camera, figures, true) | extra


def wheels_row(wheels: HandWheels, spec: WorldSpec) -> dict[str, Any]:
    """Return wheels by hand as plain values, with the true deviation after 2 m [m]."""
    return {
        "wheel_ratio": wheels.wheel_ratio,
        "tries": len(wheels.drives),
        "is_good": wheels.is_good,
        "drives": [asdict(tape) for tape in wheels.drives],
        "deviation_2m_m": deviation_of(spec, wheels.wheel_ratio),
    }


def deviation_of(spec: WorldSpec, ratio: float) -> float | None:
    """Return the deviation after 2 m [m], right positive; None for a robot that does not get that far."""
    try:
        return straight_deviation(spec.robot.parameters(), ratio)
    except DataError:
        return None


def test_1(scenario: Scenario, reference: Mapping[str, Any] | None, directory: Path) -> dict[str, Any]:
    """Run orientation and wheels with a fixed camera: the best one by hand."""
    plan = tuple(phase for phase in PLAN_TEST_1 if phase in scenario.plan)
    if reference is None:
        return {"outcome": "failed", "failure": {"name": "no_reference", "reason": "No camera by hand."}}
    return automatic(scenario.model_copy(update={"plan": plan}), directory, reference)


def automatic(scenario: Scenario, directory: Path, known: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Run the machines, from the beginning or from the last whole event in `directory`; return the result.

    Parameters
    ----------
    scenario : Scenario
    directory : Path
        Where journal and checkpoint are.
    known : mapping or None
        A camera (and mount) to begin with, as `hand_camera` gives it.
    """
    directory.mkdir(parents=True, exist_ok=True)
    session = resumed_session(scenario, directory, Parts("run"), Silent())
    if known is not None and session.run.sequence == 0:
        _teach_camera(session, known)
    drive(session)
    result = result_of(session, 0.0, {})
    kept = {name: result[name] for name in KEPT_RESULTS}
    kept["seconds"] = {"simulated": result["seconds"]["simulated"]}
    return kept | {"mount": asdict(session.run.bench.notebook.mount)}


def _teach_camera(session: Session, known: Mapping[str, Any]) -> None:
    """Write a camera, and the tilt and height of its mount when they are known, into the notebook."""
    notebook = session.run.bench.notebook
    matrix, distortion = np.array(known["matrix"]), np.array(known["distortion"])
    notebook.camera = CameraModel(matrix, distortion, model=known["model"])
    if known["mount"] is not None:
        notebook.mount = CameraMount(**known["mount"])
        notebook.mount_known = "all"
