"""A camera in the files of other programs: OpenCV's and Kalibr's, beside ROS's in `camera_files`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import yaml

from fsm_calib.errors import DataError
from fsm_calib.perception.camera_files import intrinsic_text
from fsm_calib.types import CameraModel, FloatArray


def opencv_text(camera: CameraModel, name: str, comments: str = "") -> str:
    """Return the camera as `cv2.FileStorage` reads it, with the names of OpenCV's calibration sample, whose
    `fisheye_model` says that the coefficients are those of `cv2.fisheye`.
    """
    lines = ["%YAML:1.0", "---", *(f"# {line}" for line in comments.splitlines())]
    lines += [f"camera_name: {name}", f"image_width: {camera.width}", f"image_height: {camera.height}"]
    lines += _opencv_matrix("camera_matrix", camera.matrix)
    lines += ["fisheye_model: 1"] if camera.model == "equidistant" else []
    lines += _opencv_matrix("distortion_coefficients", camera.distortion[:, None])
    return "\n".join(lines) + "\n"


def _opencv_matrix(name: str, values: FloatArray) -> list[str]:
    rows, columns = values.shape
    data = ", ".join(f"{value:.17g}" if value != int(value) else f"{value:.1f}" for value in values.ravel())
    head = [f"{name}: !!opencv-matrix", f"   rows: {rows}", f"   cols: {columns}", "   dt: d"]
    return [*head, f"   data: [ {data} ]"]


def kalibr_text(camera: CameraModel, name: str, comments: str = "") -> str:
    """Return the camera as a Kalibr camchain: pinhole with radtan distortion, which has k1, k2, p1 and p2, or with
    equidistant.

    Raises
    ------
    DataError
        The camera has more coefficients than radtan.
    """
    is_fisheye = camera.model == "equidistant"
    if np.any(camera.distortion[4:]):
        raise DataError(
            "Kalibr's radtan has k1, k2, p1 and p2; this camera has more coefficients",
            cure="Write --format opencv or ros, or calibrate with fewer: --coefficients 4.",
        )
    matrix = camera.matrix
    body = {
        "cam0": {
            "camera_model": "pinhole",
            "intrinsics": [
                float(matrix[0, 0]),
                float(matrix[1, 1]),
                float(matrix[0, 2]),
                float(matrix[1, 2]),
            ],
            "distortion_model": "equidistant" if is_fisheye else "radtan",
            "distortion_coeffs": [float(value) for value in camera.distortion[:4]],
            "resolution": [camera.width, camera.height],
            "rostopic": f"/{name}/image_raw",
        }
    }
    remarks = "".join(f"# {line}\n" for line in comments.splitlines())
    return remarks + yaml.safe_dump(body, sort_keys=False, default_flow_style=None, width=200)


FORMATS: dict[str, Callable[[CameraModel, str, str], str]] = {
    "ros": intrinsic_text,
    "duckietown": intrinsic_text,
    "opencv": opencv_text,
    "kalibr": kalibr_text,
}
"""What writes a camera, by the name that a person gives; Duckietown's form is ROS's camera_info."""
