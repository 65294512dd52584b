"""Wheels calibrated by hand, as the Duckietown manual says: a tape line, 2 m, adjust trim, a few tries.

A drive starts on the line, aimed by eye. After 2 m, or as soon as it is clear that the robot leaves the line,
the operator reads the deviation d (right positive) and the path s, and thinks of an arc: the relative mismatch
of the wheels is e = 2 L d / s^2 with L the nominal axle length, so trim changes by e / 2, times how well the
operator has the feel for it, rounded to a step of trim. Within the manual's 10 cm the work is done.

Source: Duckietown operation manual, wheel calibration; the arc is in `world2d.deviation`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fsm_calib.study.operator import OperatorSettings
from fsm_calib.types import Pose2, WheelCalibration, WheelCommand
from fsm_calib.world2d.deviation import TEST_COMMAND
from fsm_calib.world2d.fleet import RobotSpec
from fsm_calib.world2d.robot import World, WorldSettings, WorldSpec, make_world
from fsm_calib.world2d.scene import SceneSpec

WATCH_PERIOD = 0.05
"""How often the operator looks whether the drive is over [s]."""
LONGEST_DRIVE = 60.0
"""After this the operator stops a robot that does not get there [s]."""
LARGEST_TRIM = 0.5
"""No operator turns trim beyond this [1]: k = 3."""
_OPEN_FLOOR = SceneSpec(room=(50.0, 50.0))


@dataclass(frozen=True, slots=True)
class TapeDrive:
    """One drive along the tape line: trim used [1], path driven and deviation as read [m], right positive."""

    trim: float
    path: float
    deviation: float


@dataclass(frozen=True, slots=True)
class HandWheels:
    """Wheels calibrated by hand: the ratio k that is left, every drive, whether the last one passed, seconds."""

    wheel_ratio: float
    drives: tuple[TapeDrive, ...]
    is_good: bool
    seconds: float


def calibrate_wheels_by_hand(
    robot: RobotSpec, settings: WorldSettings, operator: OperatorSettings, rng: np.random.Generator
) -> HandWheels:
    """Return what an operator makes of the wheels in a few tries.

    Parameters
    ----------
    robot : RobotSpec
        The robot as it truly is.
    settings : WorldSettings
        Steps and noise of the drives.
    operator : OperatorSettings
    rng : numpy.random.Generator
    """
    trim, drives, seconds = 0.0, [], 0.0
    for _ in range(operator.tries):
        world = make_world(_world_spec(robot, settings, operator, rng))
        drives.append(drive_on_line(world, trim, operator))
        seconds += world.robot.now()
        if abs(drives[-1].deviation) < operator.good_deviation and drives[-1].path == operator.line_length:
            return HandWheels(ratio_of(trim), tuple(drives), True, seconds)
        trim = adjusted_trim(drives[-1], operator, rng)
    return HandWheels(ratio_of(trim), tuple(drives), False, seconds)


def _world_spec(
    robot: RobotSpec, settings: WorldSettings, operator: OperatorSettings, rng: np.random.Generator
) -> WorldSpec:
    """Return the tape line as a world: open floor, the robot aimed along x by eye."""
    start = Pose2(0.0, 0.0, float(rng.normal(0.0, operator.aim_sd)))
    seed = int(rng.integers(2**62))
    return WorldSpec(robot=robot, scene=_OPEN_FLOOR, start=start, settings=settings, seed=seed)


def ratio_of(trim: float) -> float:
    """Return k = (1 + trim) / (1 - trim), with gain 1 [1]."""
    return (1.0 + trim) / (1.0 - trim)


def drive_on_line(world: World, trim: float, operator: OperatorSettings) -> TapeDrive:
    """Drive until 2 m or until the robot has clearly left the line, and read path and deviation."""
    robot, truth = world.robot, world.truth
    robot.command(WheelCommand(TEST_COMMAND, ratio_of(trim) * TEST_COMMAND))
    before = (0.0, truth.pose.y)
    while robot.now() < LONGEST_DRIVE:
        robot.wait(WATCH_PERIOD)
        here = (truth.odometer, truth.pose.y)
        if here[0] >= operator.line_length:
            crossed = np.interp(operator.line_length, (before[0], here[0]), (before[1], here[1]))
            return TapeDrive(trim, operator.line_length, _read(-float(crossed), operator.reading))
        if abs(here[1]) > operator.give_up_deviation:
            break
        before = here
    path = max(_read(truth.odometer, operator.path_reading), operator.path_reading)
    return TapeDrive(trim, path, _read(-truth.pose.y, operator.reading))


def _read(length: float, step: float) -> float:
    """Return a length as it is read off a tape [m]."""
    return round(length / step) * step


def adjusted_trim(drive: TapeDrive, operator: OperatorSettings, rng: np.random.Generator) -> float:
    """Return the trim that the operator types next: against the drift, by feel."""
    mismatch = 2.0 * WheelCalibration().axle_length * drive.deviation / drive.path**2
    feel = math.exp(rng.normal(0.0, operator.feel_sd))
    trim = drive.trim + feel * mismatch / 2.0
    return max(-LARGEST_TRIM, min(LARGEST_TRIM, _read(trim, operator.trim_step)))
