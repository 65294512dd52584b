"""Where a robot went and where it looked, over moves that noise did not make."""

from __future__ import annotations

import numpy as np

from fsm_calib.recording.channels import PoseTrack
from fsm_calib.recording.chord_noise import chord_noise
from fsm_calib.types import FloatArray

MOVE_TIME = 0.5  # s: a small robot goes centimetres in it, and does not turn far
CLEARLY_MOVED = 5.0  # standard deviations of the poses' noise; its direction is then known to 0.3 rad
SHORTEST_MOVE = 0.01  # m


def clear_moves(pose: PoseTrack) -> tuple[FloatArray, FloatArray]:
    """Return the direction of motion and the heading [rad] over the clear moves of about half a second.

    A robot that pivots hardly moves its middle: what the poses' noise may have moved has no direction. Poses without a
    heading are left out.
    """
    pose = pose.rows(np.flatnonzero(np.isfinite(pose.theta) & np.isfinite(pose.x) & np.isfinite(pose.y)))
    end = np.searchsorted(pose.time, pose.time + MOVE_TIME)
    start = np.flatnonzero(end < len(pose))
    end = end[start]
    if not len(start):
        return np.zeros(0), np.zeros(0)
    dx, dy = pose.x[end] - pose.x[start], pose.y[end] - pose.y[start]
    way = np.hypot(dx, dy)
    heading = np.unwrap(pose.theta)
    turned = np.abs(heading[end] - heading[start])
    noise = np.hypot(chord_noise(pose.x), chord_noise(pose.y))
    far = way > max(SHORTEST_MOVE, CLEARLY_MOVED * noise)
    clear = far & (way > 0.3 * np.percentile(way, 95)) & (turned < 0.5)
    middle = (heading[start] + heading[end]) / 2.0
    return np.arctan2(dy, dx)[clear], middle[clear]


def agreement(direction: FloatArray, heading: FloatArray) -> float:
    """Return how well a robot drives where it looks, forward or backward: the resultant, from 0 to 1; 0 for no move."""
    return float(abs(np.exp(2j * (direction - heading)).mean())) if len(heading) else 0.0
