"""How straight a calibrated robot drives: its deviation over 2 m, by driving the physics without noise.

For small errors the path is an arc: with e = (v_left - v_right) / v the relative mismatch of the wheel speeds
[1], s the path [m] and b the axle length [m], the deviation is  e s^2 / (2 b)  to the right. Duckietown's
manual passes 0.10 m after 2 m, which is e = 0.5 %.
"""

from __future__ import annotations

import math

import numpy as np
import pymunk

from fsm_calib.errors import DataError, InputError
from fsm_calib.types import FloatArray
from fsm_calib.world2d.body import RobotBody
from fsm_calib.world2d.rollout import WORLD_STEP, Drive, simulate

TEST_DISTANCE = 2.0
"""Path of the straight-line test [m]: Duckietown operation manual, wheel calibration."""
TEST_COMMAND = 0.23
"""Left command of the test [1]: the command of the paper's program when it shuttles over the markers."""
_SLOWEST = 0.02
"""Speed below which a robot counts as not driving [m/s]."""


def straight_deviation(
    parameters: FloatArray, wheel_ratio: float, distance: float = TEST_DISTANCE, command: float = TEST_COMMAND
) -> float:
    """Return the deviation [m], right positive, after `distance` [m] of path with commands (u, wheel_ratio
    u).

    Parameters
    ----------
    parameters : array, shape (p,)
        The robot's physics (`parameters.parameter_table`).
    wheel_ratio : float
        The k to be scored, right command over left command.
    distance : float
        Path of the axle's centre [m].
    command : float
        Left command u [1].

    Raises
    ------
    InputError
        For a ratio or distance that is not positive and finite.
    DataError
        When the robot does not get that far.
    """
    for name, value in (("wheel_ratio", wheel_ratio), ("distance", distance), ("command", command)):
        if not (math.isfinite(value) and value > 0.0):
            raise InputError(f"{name} is {value:g}", where="deviation", cure="Give a positive number.")
    duration = 2.0
    while duration <= distance / _SLOWEST:
        track = straight_track(parameters, (command, wheel_ratio * command), duration)
        path = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(track[:, 0]), np.diff(track[:, 1])))])
        if path[-1] >= distance:
            return -float(np.interp(distance, path, track[:, 1]))
        duration *= 2.0
    raise DataError("the robot does not drive the test distance", cure="Check its motors and the command.")


def straight_track(parameters: FloatArray, command: tuple[float, float], duration: float) -> FloatArray:
    """Return the poses of a robot that starts at rest and holds `command` (left, right) [1], one every
    `WORLD_STEP`, shape (n, 3): x, y [m], theta [rad].

    A robot without effects drives as the world's body does, in a space without anything to touch: what a run has
    compiled serves here, too.
    """
    count = round(duration / WORLD_STEP)
    body = RobotBody(pymunk.Space(), parameters)
    if body.is_plain:
        poses = body.ride_free(np.tile(command, (count, 1)), WORLD_STEP, math.inf)
        return np.vstack([np.zeros(3), poses])
    drive = Drive(np.array([0.0]), *np.array(command)[:, None])
    times = np.linspace(0.0, count * WORLD_STEP, count + 1)
    return simulate(parameters, drive, times, (0.0, 0.0, 0.0), dt=WORLD_STEP)[:, :3]


def small_deviation(mismatch: float, axle_length: float, distance: float = TEST_DISTANCE) -> float:
    """Return e s^2 / (2 b) [m], right positive: `mismatch` e [1], `axle_length` b [m], `distance` s [m]."""
    return mismatch * distance**2 / (2.0 * axle_length)
