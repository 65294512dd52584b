"""Was the robot under way? By its measured wheels, else by what it was told."""

from __future__ import annotations

import numpy as np

from fsm_calib.recording.channels import Channel, CommandTrack, TwistTrack, WheelPair
from fsm_calib.recording.recording import Recording
from fsm_calib.types import FloatArray

IDLE = 0.1  # of what a tenth of the rows pass: a robot that is told less, or turns its wheels more slowly, may rest


def under_way(recording: Recording, time: FloatArray) -> np.ndarray | None:
    """Return whether the robot surely drove at times (n,) [s]; None where neither wheels nor commands tell.

    Nobody knows before a channel's first row and after its last.
    """
    for channel in (recording.wheel_rate, recording.wheel_speed, recording.command, recording.twist):
        if channel is None or len(channel) < 2:
            continue
        fastest = np.max(np.abs(_speeds(channel)), axis=0)
        return held_at(channel, fastest > IDLE * float(np.quantile(fastest, 0.9)), time)
    return None


def held_at(channel: Channel, says: np.ndarray, time: FloatArray) -> np.ndarray:
    """Return what the last row of a channel says at times (m,) [s], false before the first row and after the last.

    says : of each row of the channel (n,), bool.
    """
    last = np.searchsorted(channel.time, time, side="right") - 1
    return np.asarray((last >= 0) & (time <= channel.time[-1]) & says[np.maximum(last, 0)])


def _speeds(channel: WheelPair | CommandTrack | TwistTrack) -> tuple[FloatArray, FloatArray]:
    """Return the two numbers of every row that tell how fast the robot drives."""
    return (channel.v, channel.omega) if isinstance(channel, TwistTrack) else (channel.left, channel.right)
