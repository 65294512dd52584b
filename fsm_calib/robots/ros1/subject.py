"""A Duckiebot with ROS 1 as the subject of an owner's first test: a node that listens beside the program's."""

from __future__ import annotations

import os
import time
from collections.abc import Callable

import numpy as np

from fsm_calib.robots.camera import Decode
from fsm_calib.robots.guard.setup import GuardSetup
from fsm_calib.robots.ros1.messages import BOOL, IMAGE, TICK, WHEELS, message_type
from fsm_calib.robots.ros1.node import Node
from fsm_calib.robots.ros1.robot import Ros1Robot
from fsm_calib.robots.subject import Heard
from fsm_calib.types import WheelCommand


class Ros1Subject:
    """See `robots.subject.Subject`.

    Raises
    ------
    RobotLost
        The robot does not answer, or must not be driven.
    """

    least_command, turning = 0.14, 0.2

    def __init__(self, setup: GuardSetup, decode: Decode) -> None:
        self.robot, self.heard = Ros1Robot(setup, decode), Heard(decode)
        self._node = Node(f"/{setup.address.vehicle}/fsm_calib_check_{os.getpid()}", setup.address.url)
        topics = self.robot.topics
        self._button = self._node.publish(topics.estop, BOOL)
        self._node.subscribe(topics.image, IMAGE, self._frame)
        self._node.subscribe(topics.executed, WHEELS, self._executed)
        for side, topic in (("left", topics.left_tick), ("right", topics.right_tick)):
            self._node.subscribe(topic, TICK, self._counter(side))

    def _frame(self, body: bytes) -> None:
        self.heard.frame(np.asarray(message_type(IMAGE).decode(body).data).tobytes())

    def _executed(self, body: bytes) -> None:
        message = message_type(WHEELS).decode(body)
        self.heard.execute(WheelCommand(float(message.vel_left), float(message.vel_right)))

    def _counter(self, side: str) -> Callable[[bytes], None]:
        return lambda body: self.heard.count(side, int(message_type(TICK).decode(body).data))

    def press_stop(self) -> None:
        """Press this project's own button: the driver's would stay pressed."""
        self._button.publish(message_type(BOOL).stamped(time.time(), data=True))

    def close(self) -> None:
        """Stop the wheels and end the connections."""
        self.robot.close()
        self._node.close()
