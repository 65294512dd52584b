"""Which time each row of measured wheel rates stands for, and the motion that follows.

A row of the channel is one number with one stamp, and three things are logged in this form:

- ``start``: the mean until the next row, or a set-point that holds until then (so it is with a `duration`);
- ``middle``: a sample of the rate at the stamp, or a central difference about it;
- ``end``: the mean since the row before: a driver's difference of two encoder counts, known only afterwards.

Read as the wrong one, the wheels come half an interval early or late, or a whole one.
"""

from __future__ import annotations

import numpy as np

from fsm_calib.recording.channels import WheelPair
from fsm_calib.types import FloatArray


def held(pair: WheelPair) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return times [s] and the rates of both wheels that hold from each until the next, shape (n,).

    Means hold over their own time, samples from half-way to the one before until half-way to the next: at the stamps
    the travel is that of the trapezoidal rule.
    """
    time = pair.time
    if pair.duration is None and pair.stamp != "start" and len(time) > 1:
        step = _since_before(time)
        time = time - (step if pair.stamp == "end" else 0.5 * step)
    return time, pair.left, pair.right


def middle_of(pair: WheelPair) -> FloatArray:
    """Return the time [s], shape (n,), in the middle of what each row stands for."""
    time = pair.time
    if pair.duration is not None:
        return time + 0.5 * pair.duration
    if pair.stamp == "end" and len(time) > 1:
        return time - 0.5 * _since_before(time)
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


def _since_before(time: FloatArray) -> FloatArray:
    """Return the time [s] since the row before, shape (n,); before the first as before the second."""
    return np.diff(time, prepend=2.0 * time[0] - time[1])


def _summed(parts: FloatArray) -> FloatArray:
    return np.concatenate([[0.0], np.cumsum(parts)])
