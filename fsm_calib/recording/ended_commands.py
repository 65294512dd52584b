"""A log of commands that ends before the drive does: the robot goes on to do things that nobody wrote down.

A command holds until the next, so what the robot does after the last of a sparse log looks like a push or a broken
motor. Under one command a robot goes on as it goes: straight, or round. So where the last command holds for longer than
any before it, and the robot meanwhile goes clearly slower, faster or more bent than before, the log has ended with that
command: nobody knows for how long it held. Dense logs tell it by themselves (`unknown_commands`).
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from fsm_calib.recording.channels import PoseTrack
from fsm_calib.recording.chord_noise import chord_noise
from fsm_calib.recording.recording import Finding, Recording
from fsm_calib.types import FloatArray

WINDOW = 1.0  # s over which speeds are measured
SETTLED = 0.5  # s after a command in which motors follow
CLEARLY = 0.3  # of the drive's usual speed: no floor, load or battery changes a robot's so much that fast
SURELY = 6.0  # standard deviations of what the poses' noise makes of a speed
FEWEST = 9  # pauses between commands: of fewer the last is the longest too often
AXLE = 0.1  # m, of a robot whose size nobody stated


def without_unlogged_commands(recording: Recording) -> Recording:
    """Return the recording with its commands ended, and a finding, where the robot obeyed some that are not there."""
    name = "command" if recording.command is not None else "twist"
    track, pose = recording.commands, recording.pose
    if track is None or pose is None or track.stale_after is not None or len(track) < FEWEST + 1:
        return recording
    last, longest = float(track.time[-1]), float(np.diff(track.time).max())
    if not _goes_otherwise(pose, last, longest, recording.robot.axle_length or AXLE):
        return recording
    sentence = (
        f"the last is of {last:.2f} s, yet the robot went on to do what one command does not; the "
        f"{float(pose.time[-1]) - last:.1f} s after it are left out"
    )
    told = Finding(name, "ended", sentence, "kept", 1, last)
    ended: dict[str, Any] = {name: dataclasses.replace(track, ended=track.time == last)}
    return dataclasses.replace(recording, **ended, checks=(*recording.checks, told))


def _goes_otherwise(pose: PoseTrack, last: float, longest: float, axle: float) -> bool:
    """Return whether the robot moves in more than one way between its last command and the end of its poses.

    last : when the command came; longest : the longest that one held before [s].
    """
    sizes = (pose.x, pose.y) if not pose.has_heading else (pose.x, pose.y, 0.5 * axle * pose.heading)
    known = np.isfinite(sizes).all(axis=0)
    series = np.array(sizes)[:, known]
    time = pose.time[known]
    if len(time) < 2 or time[-1] < last + longest + WINDOW:
        return False
    usual = _speeds(time, series, float(time[0]))
    after = _speeds(time, series, last + SETTLED)
    noise = float(np.hypot(chord_noise(series[0]), chord_noise(series[1]))) * np.sqrt(2.0) / WINDOW
    least = max(CLEARLY * float(np.quantile(usual.max(axis=1), 0.9)), SURELY * noise)
    return bool(np.any(np.ptp(after, axis=0) > least))


def _speeds(time: FloatArray, series: FloatArray, begin: float) -> FloatArray:
    """Return the speeds (w, 2) [m/s] of the middle and of a wheel around it, in windows from `begin` on."""
    edges = np.arange(begin, time[-1], WINDOW)
    at = np.array([np.interp(edges, time, s) for s in series])
    moved = np.diff(at, axis=1) / WINDOW
    turn = moved[2] if len(moved) > 2 else np.zeros(moved.shape[1])
    return np.column_stack([np.hypot(moved[0], moved[1]), turn])
