"""A Duckiebot with ROS 1 behind `ports.Robot`."""

from __future__ import annotations

import os
import time

import numpy as np

from fsm_calib.robots.guarded import GuardedRobot, wait_until
from fsm_calib.robots.ros1.messages import IMAGE, WHEELS, message_type, stamp_of
from fsm_calib.robots.ros1.node import Node
from fsm_calib.robots.ros1.topics import Topics
from fsm_calib.types import STOP


class Ros1Robot(GuardedRobot):
    """See `GuardedRobot`. Made by `connect_ros1`."""

    node: Node | None = None

    @property
    def topics(self) -> Topics:
        """The names of its topics."""
        return Topics(self._setup.address.vehicle)

    @property
    def joined(self) -> Node:
        """The program's node."""
        if self.node is None:
            raise RuntimeError("the network is not joined yet")
        return self.node

    def _join(self) -> None:
        vehicle = self._setup.address.vehicle
        self.node = Node(f"/{vehicle}/fsm_calib_{os.getpid()}", self._setup.address.url)
        self._standby = self.node.publish(self.topics.wheels, WHEELS)
        subscriber = self.node.subscribe(self.topics.image, IMAGE, self._hear)
        wait_until(lambda: subscriber.connected > 0, "no camera publishes " + self.topics.image)
        wait_until(lambda: bool(self._standby.listeners), "no wheel driver listens to " + self.topics.wheels)

    def _hear(self, body: bytes) -> None:
        """Take a message of the camera."""
        message = message_type(IMAGE).decode(body)
        self.camera.hear(stamp_of(message), message.header.seq, np.asarray(message.data).tobytes())

    def _send_zero(self) -> None:
        kind = message_type(WHEELS)
        self._standby.publish(kind.stamped(time.time(), 0, vel_left=STOP.left, vel_right=STOP.right))

    def _leave(self) -> None:
        if self.node is not None:
            self.node.close()
