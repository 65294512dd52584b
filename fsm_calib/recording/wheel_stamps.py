"""Which time each row of measured wheel rates stands for, and the motion that follows.

A row of the channel is one number with one stamp, and three things are logged in this form:

- ``start``: the mean until the next row, or a set-point that holds until then (so it is with a `duration`);
- ``middle``: a sample of the rate at the stamp;
- ``end``: the mean since the row before: a driver's difference of two encoder counts, known only afterwards.

Read as the wrong one, the wheels come half an interval early or late, or a whole one.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import PchipInterpolator

from fsm_calib.recording.channels import WheelPair
from fsm_calib.types import FloatArray

PARTS = 4  # into which the time between two samples is cut: motors answer within one or two such times


def held(pair: WheelPair) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return times [s] and the rates of both wheels that hold from each until the next, shape (m,).

    Means hold over their own time. Between samples the rate is a monotone cubic (Fritsch, Carlson 1980, DOI
    10.1137/0717021), given as its means over `PARTS` parts.
    """
    time = pair.time
    if pair.duration is not None or pair.stamp == "start" or len(time) < 2:
        return time, pair.left, pair.right
    if pair.stamp == "end":
        return time - np.diff(time, prepend=2.0 * time[0] - time[1]), pair.left, pair.right
    share = np.arange(PARTS) / PARTS
    fine = np.append((time[:-1, None] + share * np.diff(time)[:, None]).ravel(), time[-1])
    way = PchipInterpolator(time, np.column_stack([pair.left, pair.right])).antiderivative()(fine)
    mean = np.diff(way, axis=0) / np.diff(fine)[:, None]
    return fine, np.append(mean[:, 0], pair.left[-1]), np.append(mean[:, 1], pair.right[-1])


def middle_of(pair: WheelPair) -> FloatArray:
    """Return the time [s], shape (n,), in the middle of what each row stands for."""
    time = pair.time
    if pair.duration is not None:
        return time + 0.5 * pair.duration
    if pair.stamp == "end" and len(time) > 1:
        return time - 0.5 * np.diff(time, prepend=2.0 * time[0] - time[1])
    if pair.stamp == "start" and len(time) > 1:
        return time + 0.5 * np.diff(time, append=2.0 * time[-1] - time[-2])
    return time


def travel(pair: WheelPair) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return times [s] and the integrals of both wheels' rates there, each 0 at the first; shape (n,), or (n + 1,)
    with durations.

    Samples are joined by the trapezoidal rule; means are summed.
    """
    time, sides = pair.time, (pair.left, pair.right)
    if pair.duration is not None:
        end = np.append(time, time[-1] + pair.duration[-1])
        left, right = (_summed(side * pair.duration) for side in sides)
        return end, left, right
    step = np.diff(time)
    if pair.stamp == "start":
        left, right = (_summed(step * side[:-1]) for side in sides)
    elif pair.stamp == "end":
        left, right = (_summed(step * side[1:]) for side in sides)
    else:
        left, right = (_summed(0.5 * step * (side[1:] + side[:-1])) for side in sides)
    return time, left, right


def _summed(parts: FloatArray) -> FloatArray:
    return np.concatenate([[0.0], np.cumsum(parts)])
