"""Duckietown's camera files: intrinsics as ROS's camera_info YAML, extrinsics as a homography; JSON for the
rest.

Forms: `camera_intrinsic/NAME.yaml` as ROS camera_calibration writes it (image size, camera matrix, plumb_bob
or rational_polynomial distortion, rectification, projection of the rectified image with alpha 0);
`camera_extrinsic/NAME.yaml` holds nine numbers row by row, rectified pixels (by the projection matrix) to
metres on the floor. Sources: ROS wiki camera_calibration_parsers; duckietown/dt-core,
image_processing/calibration_utils.py.
"""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from fsm_calib.errors import InputError
from fsm_calib.perception.calibration import CameraCalibration
from fsm_calib.perception.extrinsics import is_corrupt, rectified_matrix
from fsm_calib.types import CameraModel, FloatArray, LensModel, is_finite_number

_LARGEST_SIDE = 100_000  # pixels
_LARGEST_FILE = 1_000_000  # bytes; a camera file has about a thousand
_COEFFICIENTS: dict[LensModel, int] = {"plumb_bob": 5, "rational_polynomial": 8, "equidistant": 4}


def intrinsic_text(camera: CameraModel, name: str, comments: str = "") -> str:
    """Return the text of a camera_intrinsic file; each line of `comments` becomes a comment."""
    projection = np.zeros((3, 4))
    projection[:, :3] = rectified_matrix(camera)
    data = {
        "image_width": camera.width,
        "image_height": camera.height,
        "camera_name": name,
        "camera_matrix": _matrix(camera.matrix),
        "distortion_model": camera.model,
        "distortion_coefficients": _matrix(camera.distortion[None]),
        "rectification_matrix": _matrix(np.eye(3)),
        "projection_matrix": _matrix(projection),
    }
    remarks = "".join(f"# {line}\n" for line in comments.splitlines())
    return remarks + yaml.safe_dump(data, sort_keys=False, default_flow_style=None, width=200)


def write_intrinsics(path: Path, camera: CameraModel, name: str, comments: str = "") -> Path:
    """Write a camera_intrinsic file and return its path; folders are made."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(intrinsic_text(camera, name, comments), encoding="utf-8")
    return path


def read_intrinsics(path: Path) -> CameraModel:
    """Return the camera of a camera_intrinsic file, ours or Duckietown's.

    Raises
    ------
    InputError
        Not YAML, a key is missing, or a matrix has the wrong number of entries.
    """
    data = _mapping(path)
    model = data.get("distortion_model", "plumb_bob")
    if not isinstance(model, str) or model not in _COEFFICIENTS:
        raise InputError(
            f"unknown distortion_model {_brief(model)}",
            where=str(path),
            cure="Known: plumb_bob, rational_polynomial, equidistant.",
        )
    distortion = _numbers(data, "distortion_coefficients", path)
    if distortion.size not in (4, _COEFFICIENTS[model]):
        raise InputError(
            f"{distortion.size} distortion coefficients",
            where=str(path),
            cure=f"{model} has {_COEFFICIENTS[model]}.",
        )
    full = np.zeros(_COEFFICIENTS[model])
    full[: distortion.size] = distortion
    size = (_integer(data, "image_width", path), _integer(data, "image_height", path))
    return CameraModel(_numbers(data, "camera_matrix", path, 9).reshape(3, 3), full, *size, model)


def read_projection(path: Path) -> FloatArray:
    """Return the rectified image's camera matrix (3, 3) [px] of a camera_intrinsic file.

    Raises
    ------
    InputError
        The file has no projection matrix of 12 numbers.
    """
    return _numbers(_mapping(path), "projection_matrix", path, 12).reshape(3, 4)[:, :3]


def extrinsic_text(homography: FloatArray, date: str) -> str:
    """Return the text of a camera_extrinsic file; `date` as YYYY-MM-DD.

    Raises
    ------
    InputError
        Duckietown's software would refuse the homography.
    """
    if is_corrupt(homography):
        raise InputError(
            "the homography is corrupt (H[1][2] > 0)", cure="Turn the board round and calibrate again."
        )
    return yaml.safe_dump({"homography": [float(value) for value in np.ravel(homography)]}) + (
        f"# Calibrated on {date}\n"
    )


def write_extrinsics(path: Path, homography: FloatArray, date: str) -> Path:
    """Write a camera_extrinsic file and return its path; folders are made."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(extrinsic_text(homography, date), encoding="utf-8")
    return path


def read_extrinsics(path: Path) -> FloatArray:
    """Return the homography (3, 3) of a camera_extrinsic file.

    Raises
    ------
    InputError
        Not YAML, not nine numbers, or corrupt by Duckietown's rule.
    """
    values = _nine(_mapping(path).get("homography"))
    if len(values) != 9 or not all(is_finite_number(value) for value in values):
        raise InputError(
            "homography is not nine numbers", where=str(path), cure="Expected a row-major 3x3 matrix."
        )
    homography = np.array(values, dtype=float).reshape(3, 3)
    if is_corrupt(homography):
        raise InputError("the homography is corrupt (H[1][2] > 0)", where=str(path), cure="Calibrate again.")
    return homography


def calibration_json(calibration: CameraCalibration) -> dict[str, Any]:
    """Return the `camera` object of result.json and `calibrate-camera --json`: plain values only."""
    camera = calibration.camera
    return {
        "model": camera.model,
        "matrix": camera.matrix.tolist(),
        "distortion": camera.distortion.tolist(),
        "width": camera.width,
        "height": camera.height,
        "rms_px": calibration.rms_px,
        "mean_px": calibration.mean_px,
        "paper_px": calibration.paper_px,
        "predicted_px": _finite(calibration.predicted_px),
        "expected_px": _finite(calibration.predicted_map.expected),
        "cross_validated_px": _finite(calibration.cross_validated_px),
        "noise_px": calibration.noise_px,
        "views_used": calibration.views_used,
        "views_per_board": list(calibration.views_per_board),
        "views_dropped": [{"file": view.source, "reason": view.reason} for view in calibration.views_dropped],
        "deviation": calibration.parameter_deviation,
        "coverage": {name: getattr(calibration.coverage, name) for name in ("x", "y", "size", "skew")},
        "models": [
            {
                "name": trial.name,
                "coefficients": trial.coefficients,
                "rms_px": trial.rms_px,
                "cross_validated_px": _finite(trial.cross_validated_px),
                "predicted_px": _finite(trial.predicted_px),
                "verdict": trial.verdict,
            }
            for trial in calibration.models
        ],
        "board_warp_m": None if calibration.board_warp is None else asdict(calibration.board_warp),
        "refused": calibration.refused,
        "reason": calibration.reason,
    }


def _matrix(values: FloatArray) -> dict[str, Any]:
    return {
        "rows": values.shape[0],
        "cols": values.shape[1],
        "data": [float(value) for value in values.ravel()],
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _nine(block: object) -> list[Any]:
    """Return nine values from one list of nine, or from three of three; anything else is empty."""
    if (
        isinstance(block, list)
        and len(block) == 3
        and all(isinstance(r, list) and len(r) == 3 for r in block)
    ):
        return [value for row in block for value in row]
    return block if isinstance(block, list) and len(block) == 9 else []


def _mapping(path: Path) -> dict[str, Any]:
    try:
        with path.open("rb") as file:
            text = file.read(_LARGEST_FILE + 1)
        if len(text) > _LARGEST_FILE:
            raise InputError(f"has more than {_LARGEST_FILE} bytes: no camera file", where=str(path))
        data = yaml.safe_load(text.decode("utf-8-sig"))
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", where=str(path)) from error
    except (
        Exception
    ) as error:  # YAML's constructors fail in any way on what only looks like a date or a number
        raise InputError(
            "is not YAML", where=str(path), cure="Expected a camera file as ROS writes it."
        ) from error
    if not isinstance(data, dict):
        raise InputError("holds no keys", where=str(path), cure="Expected a camera file as ROS writes it.")
    return data


def _numbers(data: dict[str, Any], key: str, path: Path, count: int | None = None) -> FloatArray:
    block = data.get(key)
    values = block.get("data") if isinstance(block, dict) else None
    if not isinstance(values, list) or not all(is_finite_number(value) for value in values):
        raise InputError(f"{key} has no list of numbers under data", where=str(path))
    if count is not None and len(values) != count:
        raise InputError(f"{key} has {len(values)} numbers, expected {count}", where=str(path))
    return np.array(values, dtype=float)


def _integer(data: dict[str, Any], key: str, path: Path) -> int:
    value = data.get(key)
    if isinstance(value, bool) or not isinstance(value, int) or not 0 < value <= _LARGEST_SIDE:
        raise InputError(
            f"{key} is {_brief(value)}", where=str(path), cure="Expected a positive number of pixels."
        )
    return value


def _brief(value: object) -> str:
    """Return a value as text: of what a file nests, or writes with endless digits, only its kind."""
    is_short = isinstance(value, str | float | bool | None) or (
        isinstance(value, int) and abs(value) < 1 << 64
    )
    return repr(value) if is_short else f"a value of kind {type(value).__name__}"
