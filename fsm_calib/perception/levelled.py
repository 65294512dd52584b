r"""How the camera truly looks, from all frames together: the tilt and the height that make floor tags agree.

A calibration knows a camera's pitch and roll to a milliradian or three. Tags in one frame then lie off by millimetres
that differ with where they are in it, so that the pose jumps whenever other tags come into view. By a small turn (b, r)
down and to the right and a height larger by a share e, a point p = (X + f, y) of the floor in `base`, X ahead of a
camera at f and h above the floor, moves by

    dX = -b (X^2 + h^2) / h + r X y / h + e X,     dy = -b X y / h + r (y^2 + h^2) / h + e y

What frame and map leave at the tags' corners, less what the robot's own pose in that frame can take over, is fitted by
these three; map and camera are taken in turn. Yaw and the place ahead of the axle come from the wheels instead
(`floor_tracker.camera_offset`).

Source: Triggs et al., Bundle Adjustment - A Modern Synthesis, 2000 (self-calibration).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from fsm_calib.perception.floor_map import SeenTag, adjusted_poses
from fsm_calib.perception.floor_pose import corners_on_map
from fsm_calib.perception.plane import as_complex, sum_by_group
from fsm_calib.types import CameraMount, FloatArray, Pose2

KNOWN = (0.003, 0.003, 0.01)
"""Standard deviation of pitch and roll [rad] and of the height [1] before anything was driven."""
ROUNDS = 10
"""The first takes half of the tilt, each further one half of what is left; the height follows slowly."""
LAID = 0.001  # m, of a corner beside its noise, as the map weighs it

Frames = Sequence[Sequence[SeenTag]]


def levelled(
    frames: Frames, drawn: Mapping[int, Pose2], mount: CameraMount, size: float
) -> list[tuple[SeenTag, ...]]:
    """Return frames with their tags where a camera levelled by all of them sees them.

    Parameters
    ----------
    frames : tags in `base` of each frame, as `mount` has them.
    drawn : where the drawing has the tags.
    size : side of a tag [m].
    """
    if not frames:
        return []
    numbers = [[seen[0] for seen in frame] for frame in frames]
    of_frame = np.repeat(np.arange(len(frames)), [len(frame) for frame in frames])
    table = np.array([seen[1:] for frame in frames for seen in frame]).reshape(-1, 4)
    known = _corners(table, size)
    ways = _ways(known, mount)
    weight = 1.0 / (table[:, 3] ** 2 + LAID**2)
    camera = np.zeros(len(KNOWN))
    now = list(map(tuple, frames))
    for _ in range(ROUNDS):
        poses, places = adjusted_poses(now, drawn, size)
        there = _on_map(poses[of_frame], [places[n] for row in numbers for n in row], size)
        columns = np.concatenate([ways, (there - known)[..., None]], axis=-1)
        free = _without_motion(columns, known, weight, of_frame)
        camera = _fitted(free[..., :-1], free[..., -1], weight)
        now = _as_frames(numbers, _squares(known + ways @ camera, table[:, 3], size))
    return now


def _corners(table: FloatArray, size: float) -> np.ndarray:
    """Return corners (s, 4) of tags at x, y, heading, as complex numbers."""
    square = as_complex(corners_on_map(Pose2(), size))
    return np.asarray((table[:, 0] + 1j * table[:, 1])[:, None] + np.exp(1j * table[:, 2])[:, None] * square)


def _ways(p: np.ndarray, mount: CameraMount) -> np.ndarray:
    """Return how points (s, 4) on the floor move with pitch, roll and the share of height, shape (s, 4, 3)."""
    ahead, aside, h = p.real - mount.forward, p.imag - mount.left, mount.height
    pitch = -((ahead**2 + h**2) + 1j * ahead * aside) / h
    roll = (ahead * aside + 1j * (aside**2 + h**2)) / h
    return np.stack([pitch, roll, ahead + 1j * aside], axis=-1)


def _on_map(poses: FloatArray, places: Sequence[Pose2], size: float) -> np.ndarray:
    """Return where the map has the corners (s, 4) of tags, in `base` at poses (s, 3)."""
    lying = np.array([as_complex(corners_on_map(place, size)) for place in places])
    origin = poses[:, 0] + 1j * poses[:, 1]
    return np.asarray((lying - origin[:, None]) * np.exp(-1j * poses[:, 2])[:, None])


def _without_motion(columns: np.ndarray, p: np.ndarray, weight: FloatArray, frame: np.ndarray) -> np.ndarray:
    """Return columns (s, 4, m) less what a small motion of the robot in each frame does to points (s, 4)."""
    total = 4.0 * np.bincount(frame, weight)
    arm = 1j * (p - (sum_by_group(weight * p.sum(axis=1), frame) / total)[frame, None])
    turning = np.bincount(frame, weight * (np.abs(arm) ** 2).sum(axis=1))
    out = np.empty_like(columns)
    for k in range(columns.shape[-1]):
        column = columns[..., k]
        column = column - (sum_by_group(weight * column.sum(axis=1), frame) / total)[frame, None]
        turned = np.bincount(frame, weight * (np.conj(arm) * column).real.sum(axis=1)) / turning
        out[..., k] = column - turned[frame, None] * arm
    return out


def _fitted(ways: np.ndarray, left: np.ndarray, weight: FloatArray) -> FloatArray:
    """Return pitch, roll and share of height by weighted least squares, held by what was known."""
    weighed = np.conj(ways) * weight[:, None, None]
    normal = np.einsum("sia,sib->ab", weighed, ways).real + np.diag(np.array(KNOWN) ** -2)
    return np.asarray(np.linalg.solve(normal, np.einsum("sia,si->a", weighed, left).real))


def _squares(corners: np.ndarray, spread: FloatArray, size: float) -> FloatArray:
    """Return x, y, heading and spread (s, 4) of the squares that lie best on corners (s, 4)."""
    square, middle = as_complex(corners_on_map(Pose2(), size)), corners.mean(axis=1)
    heading = np.angle(np.sum(np.conj(square) * (corners - middle[:, None]), axis=1))
    return np.column_stack([middle.real, middle.imag, heading, spread])


def _as_frames(numbers: Sequence[Sequence[int]], table: FloatArray) -> list[tuple[SeenTag, ...]]:
    rows = iter(table.tolist())
    return [tuple((n, *next(rows)) for n in row) for row in numbers]
