"""What a robot knows from an earlier calibration: the truth, with the errors that a calibration leaves."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from fsm_calib.actions.notebook import Notebook
from fsm_calib.errors import InputError
from fsm_calib.perception.camera_files import read_extrinsics, read_intrinsics, read_projection
from fsm_calib.perception.extrinsics import mount_of
from fsm_calib.perception.fleet_camera import fleet_camera
from fsm_calib.scenario.models import Scenario
from fsm_calib.types import CameraModel, CameraMount
from fsm_calib.world2d.fleet import RobotSpec

KNOWLEDGE_STREAM = 11
"""Which random stream of the seed the errors are drawn from."""
CAMERA_SHARE = 0.01
"""The camera is this share of the way from the truth to the fleet's median [1]: 0.15 px over the image."""
TILT_ERROR = math.radians(0.1)
"""Standard deviation of pitch and roll as the boards tell them [rad]."""
YAW_ERROR = math.radians(0.5)
"""Standard deviation of the camera's yaw as the drives tell it [rad]."""
RATIO_ERROR = 0.001
"""Standard deviation of the wheel ratio [1]: 0.02 m after 2 m."""


def teach(notebook: Notebook, scenario: Scenario, robot: RobotSpec) -> None:
    """Write into the notebook what the robot knows; `known.errors` scales how wrong it is."""
    known = scenario.robot.known
    errors = known.errors * np.random.default_rng([scenario.seed, KNOWLEDGE_STREAM]).standard_normal(4)
    if known.camera:
        notebook.camera = _camera_known(robot.camera, known.errors)
        notebook.mount = _mount_known(robot.mount, errors)
    ratio = known.wheel_ratio
    if known.ratio_drift is not None:
        ratio = robot.wheel_ratio / (1.0 + known.ratio_drift) * (1.0 + RATIO_ERROR * float(errors[3]))
    if ratio is not None:
        notebook.wheel_ratio = ratio
        notebook.ratio_history = [ratio]


def teach_files(notebook: Notebook, directory: Path) -> None:
    """Write into the notebook the camera that an earlier run left in ``DIR/calibrations`` (or in `directory` itself).

    Raises
    ------
    InputError
        There is no such file, more than one, or one that cannot be read.
    """
    root = directory / "calibrations" if (directory / "calibrations").is_dir() else directory
    intrinsic, extrinsic = (_only(root / f"camera_{kind}") for kind in ("intrinsic", "extrinsic"))
    notebook.camera = read_intrinsics(intrinsic)
    notebook.mount = mount_of(read_extrinsics(extrinsic), read_projection(intrinsic))
    notebook.mount_known = "all"


def _only(folder: Path) -> Path:
    """Return the one YAML file of a folder."""
    found = sorted(folder.glob("*.yaml"))
    if len(found) != 1:
        problem = f"{len(found)} camera files" if found else "no camera file"
        raise InputError(
            problem,
            where=str(folder),
            cure="Give the folder that `fsm-calib run` wrote, with the calibration of this robot.",
        )
    return found[0]


def _camera_known(true: CameraModel, errors: float) -> CameraModel:
    """Return the true camera, moved towards the fleet's median."""
    median, share = fleet_camera(), errors * CAMERA_SHARE
    distortion = np.zeros(true.distortion.size)
    distortion[: median.distortion.size] = median.distortion
    return replace(
        true,
        matrix=(1.0 - share) * true.matrix + share * median.matrix,
        distortion=(1.0 - share) * true.distortion + share * distortion[: true.distortion.size],
    )


def _mount_known(true: CameraMount, errors: np.ndarray) -> CameraMount:
    """Return the true mount with its tilt and yaw a little wrong."""
    pitch, roll, yaw = (float(error) for error in errors[:3] * (TILT_ERROR, TILT_ERROR, YAW_ERROR))
    return replace(true, pitch=true.pitch + pitch, roll=true.roll + roll, yaw=true.yaw + yaw)
