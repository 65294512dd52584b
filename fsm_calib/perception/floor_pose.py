"""Where the robot stands on a floor whose tags are mapped, from one image: all corners of all tags at once.

Every corner's ray meets the floor at p_i in `base` (`ground.floor_points`); on the map the corner lies at q_i. The pose
(x, y, theta) minimises sum w_i |q_i - R(theta) p_i - t|^2, in closed form (Kabsch in the plane):

    theta = arg sum w_i conj(p_i - p) (q_i - q),   t = q - R(theta) p

with points as complex numbers and p, q weighted means. A pixel's error grows on the floor as (d^2 + h^2) / (f h) along
the ray, d the distance and h the camera's height; a tag's own placement adds to it: 1 / w_i is the sum of the two
squared. A tag that lies elsewhere than the map says is left out. Assumes a flat floor and a mount whose tilt is known.

Source: Kabsch, Acta Cryst. A32 (1976) 922; Umeyama, PAMI 13 (1991) 376.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fsm_calib.perception.ground import floor_points, tag_corners
from fsm_calib.perception.lens import intrinsics_vector, project
from fsm_calib.perception.plane import as_complex
from fsm_calib.perception.rotations import base_from_camera
from fsm_calib.types import CameraModel, CameraMount, FloatArray, Pose2, TagDetection

PIXEL_SD = 0.35  # px, of a corner
PLACED_SD = 0.003  # m, of a tag's place
MOVED = 0.03  # m: a tag that lies farther than this from where the map has it was moved
FARTHEST = 0.8  # m: corners beyond it are 5 px apart and tell little


@dataclass(frozen=True, slots=True)
class FloorPose:
    """The robot on the map, what is left over at the corners, root mean square [m], and the tags that told it.

    seen : number, x, y [m], heading [rad] in `base`, and standard deviation of its corners [m], of each.
    """

    pose: Pose2
    left_over: float
    seen: tuple[tuple[int, float, float, float, float], ...]

    @property
    def tags(self) -> int:
        """How many tags told it."""
        return len(self.seen)


def floor_pose(
    detections: Sequence[TagDetection],
    camera: CameraModel,
    mount: CameraMount,
    tags: Mapping[int, Pose2],
    size: float = 0.065,
) -> FloorPose | None:
    """Return the pose that one image's tags of side `size` [m] tell; None when no mapped tag is near enough."""
    known = [tag for tag in detections if tag.tag_id in tags]
    if not known:
        return None
    seen = floor_points(np.vstack([tag.corners_image for tag in known]), camera, mount).reshape(-1, 4, 2)
    meant = np.array([corners_on_map(tags[tag.tag_id], size) for tag in known])
    away = np.linalg.norm(seen.mean(axis=1), axis=1)
    near = np.isfinite(away) & (away < FARTHEST)
    if not near.any():
        return None
    p, q = as_complex(seen[near]), as_complex(meant[near])
    weight = np.repeat(_weights(away[near], camera, mount), 4).reshape(-1, 4)
    turn, shift = _aligned(p, q, weight)
    kept = np.abs(q - turn * p - shift).mean(axis=1) < MOVED
    if not kept.any():
        return None
    p, q, weight = p[kept], q[kept], weight[kept]
    turn, shift = _aligned(p, q, weight)
    left = float(np.sqrt(np.mean(np.abs(q - turn * p - shift) ** 2)))
    numbers = [tag.tag_id for tag, is_near in zip(known, near, strict=True) if is_near]
    told = _seen([n for n, is_kept in zip(numbers, kept, strict=True) if is_kept], p, weight, size)
    return FloorPose(Pose2(float(shift.real), float(shift.imag), float(np.angle(turn))), left, told)


def _seen(
    numbers: Sequence[int], corners: np.ndarray, weight: FloatArray, size: float
) -> tuple[tuple[int, float, float, float, float], ...]:
    """Return tags by the squares that lie best on their corners (k, 4) in `base`."""
    square = as_complex(tag_corners(size)[:, :2])
    middle = corners.mean(axis=1)
    heading = np.angle(np.sum(np.conj(square) * (corners - middle[:, None]), axis=1))
    spread = np.sqrt(np.maximum(1.0 / weight[:, 0] - PLACED_SD**2, 1e-12))
    return tuple(
        (number, float(z.real), float(z.imag), float(h), float(sd))
        for number, z, h, sd in zip(numbers, middle, heading, spread, strict=True)
    )


def corners_on_map(pose: Pose2, size: float) -> FloatArray:
    """Return the corners of a tag at `pose`, shape (4, 2) [m], in the AprilTag library's order."""
    c, s = np.cos(pose.theta), np.sin(pose.theta)
    corners = tag_corners(size)[:, :2]
    return np.asarray(corners @ np.array([[c, s], [-s, c]]) + [pose.x, pose.y])


def view_on_floor(
    camera: CameraModel, mount: CameraMount, cells: FloatArray, size: float = 0.065, reach: float = 0.6
) -> np.ndarray:
    """Return which places on the floor, (n, 2) in `base` [m], show a whole tag within `reach` [m], shape (n,)."""
    half = 0.75 * size * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    corners = (cells[:, None, :] + half).reshape(-1, 2)
    rotation, position = base_from_camera(mount)
    ahead = (np.column_stack([corners, np.zeros(len(corners))]) - position) @ rotation
    front = ahead[:, 2] > 0.02
    image = np.full((len(corners), 2), -1.0)
    image[front] = project(intrinsics_vector(camera), ahead[front])
    inside = front & np.all((image > 4.0) & (image < np.array([camera.width, camera.height]) - 4.0), axis=1)
    return np.asarray(inside.reshape(-1, 4).all(axis=1) & (np.hypot(*cells.T) < reach))


def _weights(away: FloatArray, camera: CameraModel, mount: CameraMount) -> FloatArray:
    """Return 1 / variance of corners at distances `away` [m] along the floor."""
    focal = float(np.sqrt(camera.matrix[0, 0] * camera.matrix[1, 1]))
    seen = PIXEL_SD * (away**2 + mount.height**2) / (focal * mount.height)
    return np.asarray(1.0 / (seen**2 + PLACED_SD**2))


def _aligned(p: np.ndarray, q: np.ndarray, weight: FloatArray) -> tuple[complex, complex]:
    """Return the turn and the shift that lay points p on q, as complex numbers."""
    total = weight.sum()
    mean_p, mean_q = (weight * p).sum() / total, (weight * q).sum() / total
    sway = complex((weight * np.conj(p - mean_p) * (q - mean_q)).sum())
    turn = sway / max(abs(sway), 1e-300)
    return turn, complex(mean_q - turn * mean_p)
