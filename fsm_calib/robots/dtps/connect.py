"""Connects to a Duckiebot with DTPS."""

from __future__ import annotations

import numpy as np

from fsm_calib.robots.battery import refuse_flat
from fsm_calib.robots.camera import Decode
from fsm_calib.robots.connection import Connection
from fsm_calib.robots.dtps.library import load
from fsm_calib.robots.dtps.robot import DtpsRobot
from fsm_calib.robots.guard.setup import GuardSetup
from fsm_calib.types import CameraModel, FloatArray, WheelCalibration


def connect_dtps(setup: GuardSetup, decode: Decode) -> Connection:
    """Return the connection to a robot; its path is dead-reckoned by the guard.

    Raises
    ------
    InputError
        Duckietown's library is not installed.
    RobotLost
        The robot does not answer, or must not be driven.
    """
    load("dtps")
    if not setup.lockstep:
        refuse_flat(setup.address.host, setup.settings.lowest_battery)
    robot = DtpsRobot(setup, decode)

    def track() -> FloatArray:
        return np.array(robot.guard.path, dtype=float).reshape(-1, 4)

    return Connection(robot, None, lambda: list(robot.guard.pose), track, robot.close, store=_store)


def _store(camera: CameraModel | None, wheels: WheelCalibration | None) -> list[str]:
    """Say that nothing is stored: ente has no service for it."""
    return ["The robot stores nothing by itself: copy the files below calibrations/ to it."]
