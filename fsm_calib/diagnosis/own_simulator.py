"""A simulator that its user can call: commands in, poses out, as a recording beside the real robot's."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline

from fsm_calib.diagnosis.inputs import with_input
from fsm_calib.diagnosis.replay.prepared import clean_poses
from fsm_calib.errors import DataError
from fsm_calib.recording.channels import PoseTrack
from fsm_calib.recording.recording import Recording
from fsm_calib.recording.wheel_stamps import held
from fsm_calib.types import FloatArray

Commands = dict[str, FloatArray]
OwnSimulator = Callable[[Commands], ArrayLike]
"""Takes columns `time` [s] with `left`, `right` (in the recording's own unit) or with `v` [m/s], `omega` [rad/s], each
row held until the next, the last row the end; returns poses (n, 4): time [s], x, y [m], theta [rad, wrapped or not]."""

SHORT = 0.05  # s by which a simulator may end before the last measured pose: one step of a slow one
FEWEST = 4  # rows of a path that can be interpolated
MAD = 1.4826  # standard deviation over median absolute deviation, normal errors


def commands_of(recording: Recording) -> Commands:
    """Return what drove the robot, as a simulator takes it: the last row repeats the last command at the end.

    Raises
    ------
    DataError
        The recording has neither commands nor wheel speeds.
    """
    r = with_input(recording)
    rates = r.wheel_rate or r.wheel_speed
    if r.command is not None:
        columns = {"time": r.command.time, "left": r.command.left, "right": r.command.right}
    elif r.twist is not None:
        columns = {"time": r.twist.time, "v": r.twist.v, "omega": r.twist.omega}
    elif rates is not None:
        columns = dict(zip(("time", "left", "right"), held(rates), strict=True))
    else:
        raise DataError(
            f"{r.source or r.robot.name}: nothing was recorded that a simulator could be driven by"
        )
    end = _end(r)
    if end <= columns["time"][-1]:
        return dict(columns)
    return {
        name: np.append(values, end if name == "time" else values[-1]) for name, values in columns.items()
    }


def path_of(simulate: OwnSimulator, recording: Recording) -> FloatArray:
    """Return the poses (n, 4) that a simulator drives by a recording's commands, the heading unwrapped.

    Raises
    ------
    DataError
        The simulator fails, or what it returns are no poses over the whole recording.
    """
    try:
        path = np.array(simulate(commands_of(recording)), dtype=float)
    except (TypeError, ValueError) as error:
        raise DataError(f"the simulator does not return numbers: {error}", cure=FORM) from error
    if path.ndim != 2 or path.shape[1] != 4 or len(path) < FEWEST:
        raise DataError(f"the simulator returned an array of shape {path.shape}", cure=FORM)
    if not np.isfinite(path).all() or (np.diff(path[:, 0]) <= 0.0).any():
        raise DataError("the simulator's poses are not finite, or its times do not increase", cure=FORM)
    if path[-1, 0] < _end(recording) - SHORT:
        raise DataError(
            f"the simulator stops at {path[-1, 0]:.2f} s, the recording lasts until {_end(recording):.2f} s",
            cure="Let it run to the time of the last command.",
        )
    path[:, 3] = np.unwrap(path[:, 3])
    return path


FORM = "It must return rows of time [s], x, y [m] and theta [rad], their times increasing."


def poses_at(path: FloatArray, time: FloatArray) -> FloatArray:
    """Return x, y [m], theta [rad] of a path (n, 4) at times (m,) [s], cubic in between; shape (m, 3).

    Before the path begins the robot stands.
    """
    inside = np.clip(time, path[0, 0], path[-1, 0])
    return np.asarray(CubicSpline(path[:, 0], path[:, 1:])(inside))


def driven(
    simulate: OwnSimulator, recording: Recording, rng: np.random.Generator
) -> tuple[Recording, FloatArray]:
    """Return what the real robot's tracker would have seen of the simulator's robot, and its exact path (n, 4).

    Poses come at the times of the real ones, with noise of the same size: what a real recording could not show is
    then not asked of the simulator either.
    """
    path = path_of(simulate, recording)
    pose, source = recording.pose, recording.source or recording.robot.name
    if pose is None:
        raise DataError(f"{source}: no poses to compare a simulator with")
    seen = poses_at(path, pose.time)
    seen = seen + rng.standard_normal(seen.shape) * _tracker_noise(recording)
    bare = replace(
        recording,
        wheel_angle=None,
        yaw_rate=None,
        displacement=None,
        state=None,
        source=f"simulator on {source}",
    )
    return replace(bare, pose=PoseTrack(pose.time, *seen.T)), path


def _tracker_noise(recording: Recording) -> FloatArray:
    """Return the standard deviations of one measured pose: x, y [m], theta [rad].

    From third differences, whose variance is 20 times that of white noise (1, 3, 3, 1) and which a path that is smooth
    over four frames does not reach; their median, so that starts and stops do not count.
    """
    p = clean_poses(recording)
    third = np.diff(np.column_stack([p.x, p.y, p.theta]), n=3, axis=0)
    spread = MAD * np.median(np.abs(third), axis=0) / np.sqrt(20.0)
    return np.array([spread[:2].mean(), spread[:2].mean(), spread[2]])


def _end(recording: Recording) -> float:
    """Return the time [s] of the last pose, or of the whole recording where there is none."""
    return float(recording.pose.time[-1] if recording.pose is not None else recording.span[1])
