"""What a socket hands to whoever runs a robot: the robot, its world where it is a simulated one, and how to let go."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from fsm_calib.ports import Robot
from fsm_calib.types import CameraModel, FloatArray, WheelCalibration
from fsm_calib.world2d.robot import World


def _ignore(event: dict[str, Any]) -> None:
    """Tell nobody."""


def _store_nothing(camera: CameraModel | None, wheels: WheelCalibration | None) -> list[str]:
    """Store nothing: a simulated robot keeps no files."""
    return []


@dataclass(frozen=True, eq=False)
class Connection:
    """A robot that is ready to be commanded.

    Parameters
    ----------
    robot : Robot
        What the activities get.
    world : World or None
        The simulated world, for scoring and pictures only; None for a robot that stands on a floor.
    pose : callable
        Returns [x, y, theta] of `base` in `world` [m, m, rad] for the journal: the true pose of a simulated
        robot; dead reckoning from the start pose of a real one.
    track : callable
        Returns the path so far, shape (n, 4): time [s], x, y [m], theta [rad]; true or dead-reckoned, as `pose`.
    close : callable
        Stops the wheels and ends the connection; may be called twice.
    tell : callable
        Publishes an event of the run (time, path, phase, trigger, sentence) for whoever listens on the robot.
    store : callable
        Stores a calibration on the robot itself and returns what was stored, a sentence each.
    """

    robot: Robot
    world: World | None
    pose: Callable[[], list[float]]
    track: Callable[[], FloatArray]
    close: Callable[[], None]
    tell: Callable[[dict[str, Any]], None] = _ignore
    store: Callable[[CameraModel | None, WheelCalibration | None], list[str]] = _store_nothing
