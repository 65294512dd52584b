"""Was the robot under way? By its measured wheels, else by what it was told."""

from __future__ import annotations

import numpy as np

from fsm_calib.recording.channels import CommandTrack, TwistTrack, WheelPair
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
        drives = fastest > IDLE * float(np.quantile(fastest, 0.9))
        last = np.searchsorted(channel.time, time, side="right") - 1
        return np.asarray((last >= 0) & (time <= channel.time[-1]) & drives[np.maximum(last, 0)])
    return None


def _speeds(channel: WheelPair | CommandTrack | TwistTrack) -> tuple[FloatArray, FloatArray]:
    """Return the two numbers of every row that tell how fast the robot drives."""
    return (channel.v, channel.omega) if isinstance(channel, TwistTrack) else (channel.left, channel.right)
