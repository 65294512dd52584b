"""When nobody knows what the wheels were told: commands that were lost on their way into a log, or that grew old.

A recorder that cannot keep up drops messages (`rosbag record` holds a hundred of each topic), and so does a wireless
link. A command holds until the next, so the robot seems to have gone on as before: a lost turn looks like a push.
ROS 1 numbers the messages of a publisher (`std_msgs/Header.seq`); where the numbers leap, the rows before were lost.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fsm_calib.recording.channels import CommandTrack, TwistTrack
from fsm_calib.types import FloatArray

MANY = 100  # rows: a pause longer than all of so many has a chance of one in a hundred
LEAST_USUAL = 0.5  # share of messages that follow the one before by the usual step: fewer, and it is no count


def unknown_spans(track: CommandTrack | TwistTrack) -> FloatArray:
    """Return the times (n, 2) [s] from which and until which commands are not known, in order.

    A span begins where the last command before a loss was logged, or `stale_after` it, and ends with the next row
    (infinity after the last). Where many commands were logged, none holds for longer than the longest pause between
    them: the log has ended. So it has after a row that is marked `ended`. The time before the first row is not told
    here.
    """
    time, after = track.time, np.append(track.time[1:], np.inf)
    lost = np.zeros(len(time), dtype=bool)
    if track.lost is not None:
        lost[:-1] = track.lost[1:] > 0.0
    if track.ended is not None:
        lost |= track.ended > 0.0
    old = after - time > (np.inf if track.stale_after is None else track.stale_after)
    begins = np.where(lost, time, time + (track.stale_after or 0.0))
    if len(time) >= MANY and not (old | lost)[-1]:
        old[-1], begins[-1] = True, time[-1] + np.diff(time).max()
    return np.column_stack([begins, after])[lost | old]


def lost_before(numbers: Sequence[int]) -> FloatArray | None:
    """Return how many messages (n,) are missing before each, by the `numbers` (n,) that a publisher gave them.

    None where they are no count: all zero, several publishers' counts mixed, or more leaps than neighbours. A topic of
    which a tool passed on every k-th message counts by k.
    """
    step = np.diff(np.asarray(numbers, dtype=np.int64))
    if not len(step) or (step <= 0).any():
        return None
    usual = int(np.median(step))
    if float(np.mean(step == usual)) < LEAST_USUAL:
        return None
    missing = np.maximum(np.rint(step / usual) - 1.0, 0.0)
    return np.concatenate([[0.0], missing])
