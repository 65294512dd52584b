"""Rows that only repeat what a sensor said before: a log on a finer grid than its sensor.

Tables are often written at one rate for all columns. A sensor that is slower holds its last number meanwhile, and the
robot seems to stand still and to jump with every new one. A number with noise never comes again to its last digit, so
such rows are known: nearly all changes are new numbers, most are followed by repeats, and the repeats last a fraction
of a second. They are dropped; a set-point that holds for long, a robot at rest on a quiet tracker and numbers of few
digits stay, and so do means that state their own durations. A pose that such a sensor holds for longer is dropped, too,
where the robot is under way all the while: it lost its way for a moment. (Registration of lidar scans stood still for
0.65 s of a turn, and what the robot did meanwhile, all in one step, was said to be a push, 0.79.)
"""

from __future__ import annotations

import dataclasses

import numpy as np

from fsm_calib.recording.channels import Channel, PoseTrack, WheelPair
from fsm_calib.recording.recording import Finding, Recording
from fsm_calib.recording.under_way import under_way
from fsm_calib.types import FloatArray

CHANNELS = ("pose", "wheel_rate", "wheel_speed")
LONGEST = 0.6  # s that a slow sensor holds a number
MOST_LONGER = 0.1  # share of changes after which a number holds longer: a robot at rest
LEAST_HELD = 0.4  # of all rows, below which a sensor is not slower than its log
LEAST_NEW = 0.9  # of the changes bring a number that never came before: fewer, and it has few digits
FEWEST = 20  # changes


def without_held_rows(recording: Recording) -> Recording:
    """Return the recording without rows that repeat a slower sensor's last number, and a finding for each channel."""
    changes: dict[str, Channel] = {}
    found: list[Finding] = []
    for name in CHANNELS:
        channel = getattr(recording, name)
        if channel is None or getattr(channel, "duration", None) is not None:
            continue
        going = under_way(recording, channel.time) if name == "pose" else None
        held = held_rows(channel.time, _numbers(channel), going)
        if not held.any():
            continue
        fresh = channel.rows(~held)
        changes[name] = fresh
        count, rate = int(held.sum()), 1.0 / float(np.median(np.diff(fresh.time)))
        sentence = (
            f"{count} of {len(channel)} rows repeat the row before to the last digit: the sensor brings about "
            f"{rate:.1f} numbers a second, the log has more; repeats dropped"
        )
        found.append(
            Finding(name, "held", sentence, "dropped", count, float(channel.time[int(np.argmax(held))]))
        )
    if not changes:
        return recording
    return dataclasses.replace(recording, **changes, checks=(*recording.checks, *found))  # type: ignore[arg-type]


def held_rows(time: FloatArray, numbers: FloatArray, going: np.ndarray | None = None) -> np.ndarray:
    """Return which rows (n,) repeat a slow sensor's number; `numbers` (n, k) at `time` (n,) [s].

    Zeros are no repeats: wheels at rest have no noise. going : whether the robot was surely under way at a row (n,),
    where that is known; a number that is held throughout is a repeat however long.
    """
    none = np.zeros(len(time), dtype=bool)
    if len(time) < 2:
        return none
    awake = np.any(numbers != 0.0, axis=1)
    same = np.concatenate([[False], np.all(numbers[1:] == numbers[:-1], axis=1)]) & awake
    begins = np.flatnonzero(~same)
    lasts = np.diff(time[begins], append=time[-1])
    moving = awake[begins]
    short = lasts <= LONGEST
    new = len(np.unique(numbers[begins[moving]], axis=0))
    lengths = np.diff(begins, append=len(time))
    held = same & np.repeat(short, lengths)
    is_slow = (
        int(moving.sum()) >= FEWEST
        and new >= LEAST_NEW * int(moving.sum())
        and float(np.mean(~short[moving])) <= MOST_LONGER
        and int(held.sum()) >= LEAST_HELD * int(awake.sum())
    )
    if not is_slow:
        return none
    if going is None:
        return held
    return held | same & np.repeat(np.logical_and.reduceat(going, begins), lengths)


def _numbers(channel: PoseTrack | WheelPair) -> FloatArray:
    """Return what a row says, (n, 2 or 3)."""
    if isinstance(channel, PoseTrack):
        return np.column_stack([channel.x, channel.y, np.nan_to_num(channel.theta)])
    return np.column_stack([channel.left, channel.right])
