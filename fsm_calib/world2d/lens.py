"""The lens seen backwards: the undistorted ray of every pixel, tabulated once per camera.

With a ray (x, y) = (X / Z, Y / Z), r2 = x^2 + y^2 and OpenCV's coefficients, the forward lens is

    c  = (1 + k1 r2 + k2 r2^2 + k3 r2^3) / (1 + k4 r2 + k5 r2^2 + k6 r2^3)
    u  = fx (c x + 2 p1 x y + p2 (r2 + 2 x^2)) + cx,    v = fy (c y + p1 (r2 + 2 y^2) + 2 p2 x y) + cy    [px]

and its inverse is found by Newton's method from a radial table. A lens model can fold: beyond some radius c r
falls again. No light arrives at the pixels beyond the fold; they stay black. Source: OpenCV, Camera
Calibration and 3D Reconstruction; Brown, Close-range camera calibration, 1971.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fsm_calib.errors import InputError
from fsm_calib.types import CameraModel, CameraMount, FloatArray, Pose2, read_only

_WIDEST = math.tan(math.radians(86.0))
"""Largest |ray| that is drawn [1]: 86 deg off the axis."""
_NEWTON_STEPS = 12
_LEAST_SLOPE = 0.02
"""Smallest d(c r)/dr that still counts as seeing [1]; below it a pixel covers more than fifty times the
centre's angle.
"""
_MAX_BLIND = 0.05
"""Share of the pixels that may lie beyond the fold."""


@dataclass(frozen=True, eq=False)
class RayTable:
    """The rays of a camera's pixels.

    rays : float32, shape (height + 2, width + 2, 2), (x, y) of each pixel centre with one row or column more
    on each side, clipped to 86 deg; coarse : float32, (ceil(height / 2), ceil(width / 2), 2), the mean ray of
    2 x 2 pixels; blind : bool, shape (height, width), pixels without a ray; widest : largest |ray| [1].
    """

    camera: CameraModel
    rays: NDArray[Any]
    coarse: NDArray[Any]
    blind: NDArray[np.bool_]
    widest: float

    @property
    def has_blind(self) -> bool:
        """Tell whether some pixels see nothing."""
        return bool(self.blind.any())


def _coefficients(camera: CameraModel) -> FloatArray:
    padded = np.zeros(8)
    padded[: camera.distortion.size] = camera.distortion
    return padded


def distort_rays(camera: CameraModel, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return distorted coordinates [1] of rays (x, y) [1], same shapes."""
    k1, k2, p1, p2, k3, k4, k5, k6 = _coefficients(camera)
    r2 = x * x + y * y
    factor = (1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1.0 + r2 * (k4 + r2 * (k5 + r2 * k6)))
    return (
        factor * x + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
        factor * y + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
    )


def _radial_table(camera: CameraModel) -> tuple[FloatArray, FloatArray]:
    """Return radii and distorted radii [1] up to the widest drawn ray or the fold, whichever is nearer."""
    k1, k2, _, _, k3, k4, k5, k6 = _coefficients(camera)
    radius = np.linspace(0.0, _WIDEST, 6000)
    r2 = radius * radius
    below = 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6))
    curve = radius * (1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))) / np.where(below > 0.0, below, 1.0)
    slope = np.gradient(curve, radius)
    bad = (below <= 0.0) | (slope < _LEAST_SLOPE)
    end = int(np.argmax(bad)) if bool(bad.any()) else radius.size
    return radius[:end], curve[:end]


def sees_everywhere(camera: CameraModel) -> bool:
    """Tell whether every pixel of the image has a ray: the lens does not fold before the farthest corner."""
    fx, fy, cx, cy = camera.matrix[0, 0], camera.matrix[1, 1], camera.matrix[0, 2], camera.matrix[1, 2]
    corners = [
        math.hypot((u - cx) / fx, (v - cy) / fy)
        for u in (0, camera.width - 1)
        for v in (0, camera.height - 1)
    ]
    return max(corners) <= float(_radial_table(camera)[1][-1])


def _newton(camera: CameraModel, target: FloatArray, start: FloatArray) -> FloatArray:
    """Refine rays (2, n) so that their distorted coordinates are `target` (2, n); derivative by central
    differences.
    """
    ray, step = start.copy(), 1e-6
    for _ in range(_NEWTON_STEPS):
        error = np.array(distort_rays(camera, *ray)) - target
        if float(np.max(np.abs(error))) < 1e-10:
            break
        dx = (
            np.array(distort_rays(camera, ray[0] + step, ray[1]))
            - distort_rays(camera, ray[0] - step, ray[1])
        ) / (2.0 * step)
        dy = (
            np.array(distort_rays(camera, ray[0], ray[1] + step))
            - distort_rays(camera, ray[0], ray[1] - step)
        ) / (2.0 * step)
        determinant = dx[0] * dy[1] - dx[1] * dy[0]
        determinant = np.where(np.abs(determinant) < 1e-4, 1e-4, determinant)
        move = (
            np.array([dy[1] * error[0] - dy[0] * error[1], dx[0] * error[1] - dx[1] * error[0]]) / determinant
        )
        ray -= np.clip(move, -0.2, 0.2)
    return ray


def ray_table(camera: CameraModel) -> RayTable:
    """Tabulate the rays of `camera`.

    Raises
    ------
    InputError
        When the focal length is not positive or more than 5 % of the pixels lie beyond the lens's fold.
    """
    fx, fy, cx, cy = camera.matrix[0, 0], camera.matrix[1, 1], camera.matrix[0, 2], camera.matrix[1, 2]
    values = np.concatenate([camera.matrix.ravel(), camera.distortion])
    if not (np.all(np.isfinite(values)) and fx > 0.0 and fy > 0.0):
        raise InputError(
            "the camera's matrix or distortion is not usable", where="camera", cure="Give finite numbers."
        )
    v, u = np.mgrid[-1 : camera.height + 1, -1 : camera.width + 1].astype(float)
    target = np.array([((u - cx) / fx).ravel(), ((v - cy) / fy).ravel()])
    radius, curve = _radial_table(camera)
    wanted = np.hypot(*target)
    blind = (wanted > curve[-1]).reshape(v.shape)[1:-1, 1:-1]
    if float(blind.mean()) > _MAX_BLIND:
        raise InputError(
            f"the lens folds inside the image: {100.0 * blind.mean():.0f} % of the pixels have no ray",
            where="camera",
            cure="Use distortion coefficients that are monotone over the whole image.",
        )
    start = target * (np.interp(wanted, curve, radius) / np.maximum(wanted, 1e-12))
    seen = wanted <= curve[-1]
    start[:, seen] = _newton(camera, target[:, seen], start[:, seen])
    norm = np.hypot(*start)
    start *= np.minimum(1.0, radius[-1] / np.maximum(norm, 1e-12))
    rays = np.ascontiguousarray(start.T.reshape(*v.shape, 2), dtype=np.float32)
    rays.setflags(write=False)
    half = ((camera.width + 1) // 2, (camera.height + 1) // 2)
    coarse = cv2.resize(rays[1:-1, 1:-1], half, interpolation=cv2.INTER_AREA)
    return RayTable(
        camera, rays, coarse, read_only(blind, bool), float(np.hypot(rays[..., 0], rays[..., 1]).max())
    )


def camera_pose(base: Pose2, mount: CameraMount) -> tuple[FloatArray, FloatArray]:
    """Return the rotation world_from_camera (3, 3) and the camera's position in `world` (3,) [m].

    R = Rz(theta + yaw) Ry(pitch) Rx(roll) P, where P's columns are the axes of a level camera (x right, y
    down, z forward) in `base`; a positive pitch looks down, a positive roll lowers the camera's right side.
    """
    level = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    turn = base.theta + mount.yaw
    cz, sz, cp, sp = math.cos(turn), math.sin(turn), math.cos(mount.pitch), math.sin(mount.pitch)
    cr, sr = math.cos(mount.roll), math.sin(mount.roll)
    yaw = np.array([[cz, -sz, 0.0], [sz, cz, 0.0], [0.0, 0.0, 1.0]])
    pitch = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
    roll = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
    c, s = math.cos(base.theta), math.sin(base.theta)
    position = np.array(
        [
            base.x + c * mount.forward - s * mount.left,
            base.y + s * mount.forward + c * mount.left,
            mount.height,
        ]
    )
    return yaw @ pitch @ roll @ level, position
