"""What a late command does to a drive: the robot falls behind by the lateness times each change of its speed.

For a robot that follows its commands late by d [s], with forward speed v and turning speed omega in its own frame,

    v(t - d) = v(t) - d v'(t) + O(d^2),

so from one event to the next it lacks d times the change of v [m/s] of way, and d times that of omega [rad/s] of turn.
The changes are those of the measured path: they come when the robot answers, whatever delays and lags are between.
"""

from __future__ import annotations

import numpy as np

from fsm_calib.diagnosis.replay.smoothing import SmoothTrack
from fsm_calib.recording.channels import CommandTrack
from fsm_calib.recording.recording import Recording
from fsm_calib.types import FloatArray

EARLY = 0.05  # s: a jitter is hardly larger, so no command is followed sooner before its stamp


def speed_changes(track: SmoothTrack, picked: np.ndarray) -> FloatArray:
    """Return by how much the forward speed [m/s] and the turning speed [rad/s] changed to each event, (n, 2)."""
    forward = track.vx * np.cos(track.theta) + track.vy * np.sin(track.theta)
    speeds = np.column_stack([forward, track.omega])[picked]
    return np.diff(speeds, axis=0, prepend=speeds[:1])


def heard_anew(recording: Recording, time: FloatArray, frame: float) -> np.ndarray:
    """Return a mask (n,) of the events since whose last one another command began to show: its lateness is its own.

    It may come early, and a path that is smoothed over a `frame` [s] answers as much earlier.
    """
    commands = recording.commands
    if commands is None or not len(commands):
        return np.zeros(len(time), dtype=bool)
    pair = (
        (commands.left, commands.right)
        if isinstance(commands, CommandTrack)
        else (commands.v, commands.omega)
    )
    changed = np.any([np.diff(row, prepend=np.nan) != 0.0 for row in pair], axis=0)
    so_far = np.searchsorted(commands.time[changed] - EARLY - frame, time, side="right")
    return np.asarray(np.diff(so_far, prepend=so_far[:1]) > 0)
