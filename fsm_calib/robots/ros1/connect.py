"""Connects to a Duckiebot with ROS 1."""

from __future__ import annotations

import numpy as np

from fsm_calib.robots.battery import refuse_flat
from fsm_calib.robots.camera import Decode
from fsm_calib.robots.connection import Connection
from fsm_calib.robots.guard.setup import GuardSetup
from fsm_calib.robots.ros1.robot import Ros1Robot
from fsm_calib.robots.ros1.state import StateTeller
from fsm_calib.robots.ros1.store import store_calibration
from fsm_calib.types import CameraModel, FloatArray, WheelCalibration


def connect_ros1(setup: GuardSetup, decode: Decode) -> Connection:
    """Return the connection to a robot; its path is dead-reckoned by the guard.

    Raises
    ------
    RobotLost
        The robot does not answer, or must not be driven.
    """
    if not setup.lockstep:
        refuse_flat(setup.address.host, setup.settings.lowest_battery)
    robot = Ros1Robot(setup, decode)

    def track() -> FloatArray:
        return np.array(robot.guard.path, dtype=float).reshape(-1, 4)

    teller = StateTeller(robot.joined, robot.topics)

    def store(camera: CameraModel | None, wheels: WheelCalibration | None) -> list[str]:
        return store_calibration(robot.joined, robot.topics, camera, wheels)

    return Connection(
        robot, None, lambda: list(robot.guard.pose), track, robot.close, tell=teller.tell, store=store
    )
