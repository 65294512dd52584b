"""Where floor tags truly lie, and the robot in every frame, from all frames together: a small bundle adjustment.

Tags are laid by hand, 3 mm and 0.3 deg off the drawing, which a pose by the drawing carries on: it moves by a
millimetre whenever a tag comes into view. Every frame f sees corners p_fki of tags k in `base`; the map has corners
c_i of a tag at its pose T_k. Poses P_f and T_k minimise

    sum_fk w_fk sum_i |T_k c_i - P_f p_fki|^2 + sum_k w_0 sum_i |T_k c_i - T_k0 c_i|^2

where T_k0 is the drawing, which also holds the map in its place. Both halves are closed forms (`floor_pose`), taken
in turn; each step lowers the sum. Shapes: s observations in all.

Source: Triggs et al., Bundle Adjustment - A Modern Synthesis, 2000.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from fsm_calib.perception.floor_pose import PLACED_SD, corners_on_map
from fsm_calib.perception.plane import as_complex, sum_by_group
from fsm_calib.types import FloatArray, Pose2

SeenTag = tuple[int, float, float, float, float]
"""A tag in one frame: its number, x, y [m] and heading [rad] in `base`, standard deviation of its corners [m]."""

ROUNDS = 30  # a few millimetres shrink by a third in each


def adjusted_poses(
    frames: Sequence[Sequence[SeenTag]], drawn: Mapping[int, Pose2], size: float = 0.065
) -> tuple[FloatArray, dict[int, Pose2]]:
    """Return the robot's pose in every frame, shape (n, 3) x, y [m], theta [rad], and the tags' places.

    Every frame sees at least one tag of the drawing; other tags must be left out beforehand.
    """
    numbers = sorted({seen[0] for frame in frames for seen in frame})
    row = {number: k for k, number in enumerate(numbers)}
    of_frame = np.array([f for f, frame in enumerate(frames) for _ in frame])
    of_tag = np.array([row[seen[0]] for frame in frames for seen in frame])
    table = np.array([seen[1:] for frame in frames for seen in frame]).reshape(-1, 4)
    p = _corners(table[:, 0] + 1j * table[:, 1], table[:, 2], size)
    weight = _weights(table[:, 3])
    nominal = np.array([as_complex(corners_on_map(drawn[number], size)) for number in numbers])
    square = nominal - nominal.mean(axis=1, keepdims=True)
    lying = nominal.copy()
    for _ in range(ROUNDS):
        turn, shift = _groups(p, lying[of_tag], weight, of_frame, len(frames))
        told = turn[of_frame, None] * p + shift[of_frame, None]
        lying = _laid(told, nominal, square, weight, of_tag)
    turn, shift = _groups(p, lying[of_tag], weight, of_frame, len(frames))
    places = {n: _pose_of(lying[k], nominal[k], drawn[n]) for k, n in enumerate(numbers)}
    return np.column_stack([shift.real, shift.imag, np.angle(turn)]), places


def pose_spreads(frames: Sequence[Sequence[SeenTag]], size: float = 0.065) -> FloatArray:
    """Return how well the corners of each frame's tags tell its pose: standard deviations (n, 2) of place [m] and
    heading [rad].

    With weights w_i of corners p_i in `base` and their weighted mean p:

        var theta = 1 / sum w_i |p_i - p|^2,    var place = 1 / sum w_i + |p|^2 var theta

    the place in its worst direction: an error of a tag's heading carries the robot round that tag.
    """
    of_frame = np.array([f for f, frame in enumerate(frames) for _ in frame])
    table = np.array([seen[1:] for frame in frames for seen in frame]).reshape(-1, 4)
    p, weight = _corners(table[:, 0] + 1j * table[:, 1], table[:, 2], size), _weights(table[:, 3])
    total = 4.0 * np.bincount(of_frame, weight, len(frames))
    mean = sum_by_group(weight * p.sum(axis=1), of_frame, len(frames)) / total
    across = np.sum(np.abs(p - mean[of_frame, None]) ** 2, axis=1)
    heading = 1.0 / np.bincount(of_frame, weight * across, len(frames))
    return np.sqrt(np.column_stack([1.0 / total + np.abs(mean) ** 2 * heading, heading]))


def _weights(spread: FloatArray) -> FloatArray:
    """Return the weight [1/m^2] of corners whose standard deviation is `spread` [m] beside what is left of the map."""
    return np.asarray(1.0 / (spread**2 + (0.3 * PLACED_SD) ** 2))


def _corners(centre: np.ndarray, heading: FloatArray, size: float) -> np.ndarray:
    """Return corners (s, 4) of tags at centres (s,) with headings (s,), as complex numbers."""
    square = as_complex(corners_on_map(Pose2(), size))
    return np.asarray(centre[:, None] + np.exp(1j * heading)[:, None] * square)


def _groups(
    p: np.ndarray, q: np.ndarray, weight: FloatArray, group: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return for every group the turn and the shift (count,) that lay its corners p (s, 4) on q."""
    total = 4.0 * np.bincount(group, weight, count)
    mean_p, mean_q = (sum_by_group(weight * z.sum(axis=1), group, count) / total for z in (p, q))
    across = np.conj(p - mean_p[group, None]) * (q - mean_q[group, None])
    sway = sum_by_group(weight * across.sum(axis=1), group, count)
    turn = sway / np.maximum(np.abs(sway), 1e-300)
    return turn, mean_q - turn * mean_p


def _laid(
    told: np.ndarray, nominal: np.ndarray, square: np.ndarray, weight: FloatArray, of_tag: np.ndarray
) -> np.ndarray:
    """Return the corners (k, 4) of the tags as frames tell them (s, 4), held by the drawing; squares stay squares."""
    count, hold = len(nominal), PLACED_SD**-2
    total = np.bincount(of_tag, weight, count) + hold
    summed = np.column_stack([sum_by_group(weight * told[:, i], of_tag, count) for i in range(4)])
    mean = (summed + hold * nominal) / total[:, None]
    middle = mean.mean(axis=1, keepdims=True)
    sway = np.sum(np.conj(square) * (mean - middle), axis=1, keepdims=True)
    return np.asarray(middle + sway / np.maximum(np.abs(sway), 1e-300) * square)


def _pose_of(corners: np.ndarray, nominal: np.ndarray, drawn: Pose2) -> Pose2:
    middle = corners.mean()
    turn = np.angle(np.sum(np.conj(nominal - nominal.mean()) * (corners - middle)))
    return Pose2(float(middle.real), float(middle.imag), drawn.theta + float(turn))
