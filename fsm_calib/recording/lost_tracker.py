"""Poses that a tracker repeats while it has lost the robot: it stands still under way, and then leaps.

Motion capture, tags and map matching that lose a robot often say the last pose again, to the last digit, until they
have it back. Taken for measurements such rows are a stop and a leap, for which a push or a motor's fault would be said.
A robot that really rested leaves its place slowly: its first step is shorter than those after it. So repeats go where
the robot was told to drive, or its wheels turned, meanwhile, and the step after them is far longer than the next.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from fsm_calib.recording.recording import Finding, Recording
from fsm_calib.recording.runs import runs_of
from fsm_calib.recording.under_way import under_way
from fsm_calib.types import FloatArray

FEWEST = 3  # repeats in a row; two at a time come of two clocks that drift past each other
LEAP = 2.5  # times the steps after it; of a robot that goes on as before it is one more than the repeats
NEXT = 3  # steps after the leap with which it is compared


def without_lost_poses(recording: Recording) -> Recording:
    """Return the recording without the poses that a tracker repeated while it had lost the robot, and a finding."""
    pose = recording.pose
    if pose is None or len(pose) < FEWEST + NEXT:
        return recording
    going = under_way(recording, pose.time)
    if going is None:
        return recording
    rows = np.column_stack([pose.x, pose.y, np.nan_to_num(pose.theta)])
    lost = lost_rows(rows, going)
    if not lost.any():
        return recording
    at, count = float(pose.time[int(np.argmax(lost))]), int(lost.sum())
    sentence = (
        f"{count} of {len(pose)} poses repeat the one before to the last digit while the robot drives, first at "
        f"{at:.2f} s, and then leap: the tracker had lost it; repeats dropped"
    )
    found = Finding("pose", "lost", sentence, "dropped", count, at)
    return dataclasses.replace(recording, pose=pose.rows(~lost), checks=(*recording.checks, found))


def lost_rows(poses: FloatArray, going: np.ndarray) -> np.ndarray:
    """Return which of the poses (n, 3) [m, m, rad] were repeated while the tracker had lost the robot.

    going : whether the robot was under way at a row (n,).
    """
    lost = np.zeros(len(poses), dtype=bool)
    size = _sizes(np.diff(poses, axis=0))
    for begin, leap in runs_of(size == 0.0):
        after = size[leap + 1 : leap + 1 + NEXT]
        if leap - begin < FEWEST or not len(after) or not going[begin : leap + 1].any():
            continue
        if size[leap] > LEAP * float(np.median(after)):
            lost[begin + 1 : leap + 1] = True
    return lost


def _sizes(steps: FloatArray) -> FloatArray:
    """Return how long steps (n, 3) are [1], the usual way and the usual turn of one that is none of a rest being 1."""
    ways = np.column_stack([np.hypot(steps[:, 0], steps[:, 1]), np.abs(np.angle(np.exp(1j * steps[:, 2])))])
    usual = [float(np.median(way[way > 0.0])) if (way > 0.0).any() else 1.0 for way in ways.T]
    return np.asarray(np.hypot(ways[:, 0] / usual[0], ways[:, 1] / usual[1]))
