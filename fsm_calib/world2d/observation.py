"""From the robot's states to what the pose sensor reports: its clock, its filter, its place on the robot, its map.

The hooks `clock`, `smooth`, `mount` and `observe` of the active effects act in their order; all is NumPy on whole
recordings.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fsm_calib.types import FloatArray, Pose2
from fsm_calib.world2d.effects import Effect, hooked
from fsm_calib.world2d.kernel import flag_places
from fsm_calib.world2d.parameters import parameter_table
from fsm_calib.world2d.rollout import FIT_STEP, Drive, Flags, active_flags, simulate

FILTER_STEP = 0.01
"""Seconds between the poses of which a prediction's filters make what is reported."""


def _active(parameters: FloatArray, stage: str, on: Flags | None) -> list[tuple[Effect, FloatArray]]:
    """Return the active effects with a hook for the stage, in their order, with their parameters."""
    on = active_flags(parameters) if on is None else on
    first, flags = parameter_table().first, flag_places()
    return [
        (e, parameters[first[e.name] : first[e.name] + len(e.parameters)])
        for e in hooked(stage)
        if on[flags[e.name]]
    ]


def robot_time(parameters: FloatArray, stamps: FloatArray, on: Flags | None = None) -> FloatArray:
    """Return the robot's time [s] at which the poses with the given stamps [s] were true, shape (n,)."""
    time = np.array(stamps, dtype=float)
    for effect, values in _active(parameters, "clock", on):
        time = effect.hooks["clock"](values, time)
    return time


def smoothed(
    parameters: FloatArray, times: FloatArray, poses: FloatArray, on: Flags | None = None
) -> FloatArray:
    """Return what the pose sensor's filter makes of the robot's poses, shape (n, 3), at increasing `times` [s]."""
    seen = np.array(poses, dtype=float)[:, :3]
    for effect, values in _active(parameters, "smooth", on):
        seen = effect.hooks["smooth"](values, times, seen)
    return seen


def observe(
    parameters: FloatArray,
    times: FloatArray,
    poses: FloatArray,
    places: FloatArray | None = None,
    on: Flags | None = None,
) -> FloatArray:
    """Return what the pose sensor reports for the robot's poses, shape (n, 3) [m, m, rad], at times (n,) [s].

    `times` are the robot's, since the recording's zero. `places`, shape (n, 2) [m], is where the robot is known to have
    been (for effects of places); default: the poses.
    """
    measured = np.array(poses, dtype=float)[:, :3]
    where = measured[:, :2].copy() if places is None else np.asarray(places, dtype=float)
    for effect, values in _active(parameters, "mount", on):
        measured = effect.hooks["mount"](values, times, measured)
    for effect, values in _active(parameters, "observe", on):
        measured = effect.hooks["observe"](values, measured, where)
    return measured


def base_pose(parameters: FloatArray, measured: Pose2) -> Pose2:
    """Return the pose of the axle centre for a measured pose: the inverse of the place that the sensor has at last (not
    of map errors).
    """
    table = parameter_table()
    x, y, yaw = (parameters[table.place(n)] for n in ("sensor_offset.x", "sensor_offset.y", "sensor_yaw.yaw"))
    return Pose2(measured.x, measured.y, measured.theta).then(Pose2(0.0, 0.0, -yaw)).then(Pose2(-x, -y, 0.0))


@dataclass(frozen=True, eq=False)
class Prediction:
    """What would be measured: poses at the stamps, shape (n, 3) [m, m, rad, not wrapped]; wheel angles, shape
    (m, 2) [rad]; the robot's states at the poses' true times, shape (n, 12), columns `rollout.COLUMNS`.
    """

    poses: FloatArray
    wheel_angles: FloatArray
    states: FloatArray


def predict(
    parameters: FloatArray,
    drive: Drive,
    stamps: FloatArray,
    x0: Sequence[float] | FloatArray,
    pose_track: FloatArray | None = None,
    wheel_times: FloatArray | None = None,
    dt: float = FIT_STEP,
) -> Prediction:
    """Drive the robot and return what its sensors would report.

    Parameters
    ----------
    parameters, drive, pose_track, dt
        As in `rollout.simulate`.
    stamps : array, shape (n,)
        Time stamps of the poses [s], increasing, on the pose sensor's clock.
    x0 : sequence
        Pose of the axle, or pose and twist, at the earliest of all times.
    wheel_times : array, shape (m,), optional
        Times of the wheel angles [s] on the robot's clock.
    """
    on = active_flags(parameters)
    true_times = robot_time(parameters, stamps, on)
    asked = [true_times, np.zeros(0) if wheel_times is None else wheel_times]
    asked.append(_between(true_times) if _active(parameters, "smooth", on) else np.zeros(0))
    grid, places = np.unique(np.concatenate(asked), return_inverse=True)
    simulated = simulate(parameters, drive, grid, x0, pose_track, dt)[places.ravel()]
    states, wheels, fine = np.split(simulated, np.cumsum([len(times) for times in asked[:2]]))
    where = None
    if pose_track is not None:
        where = np.column_stack([np.interp(true_times, pose_track[:, 0], pose_track[:, i]) for i in (1, 2)])
    seen = states[:, :3].copy()
    if len(fine):
        changed = smoothed(parameters, asked[2], fine, on) - fine[:, :3]
        seen += np.column_stack([np.interp(true_times, asked[2], column) for column in changed.T])
    return Prediction(observe(parameters, true_times, seen, where, on), wheels[:, 6:8], states)


def _between(times: FloatArray) -> FloatArray:
    """Return times (n,) [s], `FILTER_STEP` apart, over those of some poses: a filter sees more than is reported."""
    return np.asarray(times[0] + FILTER_STEP * np.arange(int((times[-1] - times[0]) / FILTER_STEP) + 1))
