"""Rotations and rigid motions, in batches.

Rotation vectors follow Rodrigues: direction = axis, length = angle [rad]. Every function takes leading batch
dimensions. Source: Hartley and Zisserman, Multiple View Geometry (2nd ed.), A4.3.2.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from fsm_calib.types import CameraMount, FloatArray

#: camera axes (x right, y down, z forward) written in base axes (x forward, y left, z up), for an untilted
#: camera
BASE_FROM_OPTICAL = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
_SMALL_ANGLE = 1e-8  # rad; below it the series of sin(a)/a is used


def skew(vectors: FloatArray) -> FloatArray:
    """Return the cross-product matrices of `vectors`, shape (..., 3) -> (..., 3, 3)."""
    x, y, z = np.moveaxis(np.asarray(vectors, dtype=float), -1, 0)
    zero = np.zeros_like(x)
    rows = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1)
    return rows.reshape(*rows.shape[:-1], 3, 3)


def rotation_from_vector(vectors: FloatArray) -> FloatArray:
    """Return the rotation matrices of rotation vectors [rad], shape (..., 3) -> (..., 3, 3).

    R = I + sin(a)/a K + (1 - cos(a))/a^2 K^2 with a = |v| [rad] and K = skew(v).
    """
    vectors = np.asarray(vectors, dtype=float)
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    safe = np.where(angle < _SMALL_ANGLE, 1.0, angle)
    first = np.where(angle < _SMALL_ANGLE, 1.0, np.sin(safe) / safe)
    second = np.where(angle < _SMALL_ANGLE, 0.5, (1.0 - np.cos(safe)) / safe**2)
    matrix = skew(vectors)
    return np.eye(3) + first * matrix + second * (matrix @ matrix)


def vector_from_rotation(rotation: FloatArray) -> FloatArray:
    """Return the rotation vector [rad] of one rotation matrix, shape (3, 3) -> (3,)."""
    trace = np.clip((np.trace(rotation) - 1.0) / 2.0, -1.0, 1.0)
    axis = np.array(
        [rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]]
    )
    angle, sine = float(np.arccos(trace)), float(np.linalg.norm(axis)) / 2.0
    if sine > 1e-6:
        return axis / (2.0 * sine) * float(np.arctan2(sine, trace))
    if angle < 1.0:
        return axis / 2.0
    # half a turn: the axis is the eigenvector of eigenvalue 1 of the symmetric part
    _, vectors = np.linalg.eigh((rotation + rotation.T) / 2.0)
    return vectors[:, 2] * angle


def nearest_rotation(matrix: FloatArray) -> FloatArray:
    """Return the rotation nearest to `matrix` (3, 3) in the Frobenius norm."""
    left, _, right = np.linalg.svd(matrix)
    return left @ np.diag([1.0, 1.0, float(np.linalg.det(left @ right))]) @ right


def yaw_rotation(yaw: float) -> FloatArray:
    """Return the rotation about the vertical by `yaw` [rad], counter-clockwise."""
    return rotation_from_vector(np.array([0.0, 0.0, yaw]))


def tilt_rotation(pitch: float, roll: float) -> FloatArray:
    """Return the rotation of the camera's box in levelled axes: pitch down [rad] about y left, then roll
    [rad] about x.
    """
    return rotation_from_vector(np.array([0.0, pitch, 0.0])) @ rotation_from_vector(
        np.array([roll, 0.0, 0.0])
    )


@lru_cache(maxsize=64)
def base_from_camera(mount: CameraMount) -> tuple[FloatArray, FloatArray]:
    """Return the camera's rotation (3, 3) and position (3,) [m] in `base`, read-only.

    R = Rz(yaw) Ry(pitch) Rx(roll) P with P the axes of an untilted camera; a positive pitch looks down, a
    positive roll turns the camera clockwise as seen from behind, so that its right side goes down.
    """
    rotation = yaw_rotation(mount.yaw) @ tilt_rotation(mount.pitch, mount.roll) @ BASE_FROM_OPTICAL
    position = np.array([mount.forward, mount.left, mount.height])
    rotation.setflags(write=False)
    position.setflags(write=False)
    return rotation, position


def mount_from_pose(rotation: FloatArray, position: FloatArray) -> CameraMount:
    """Return the mount of a camera with `rotation` (3, 3) and `position` (3,) [m] in `base`: undo
    `base_from_camera`.
    """
    box = rotation @ BASE_FROM_OPTICAL.T
    pitch = float(np.arcsin(np.clip(-box[2, 0], -1.0, 1.0)))
    return CameraMount(
        forward=float(position[0]),
        left=float(position[1]),
        height=float(position[2]),
        pitch=pitch,
        roll=float(np.arctan2(box[2, 1], box[2, 2])),
        yaw=float(np.arctan2(box[1, 0], box[0, 0])),
    )
