"""A served Duckiebot as ROS 1 nodes see it: Duckietown's topics, services and parameters (daffy)."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsm_calib.errors import LinkLost
from fsm_calib.robots.ros1.messages import (
    BOOL,
    CAMERA_INFO,
    CLOCK,
    EMPTY_SERVICE,
    IMAGE,
    POSE,
    TEXT,
    TICK,
    WHEELS,
    header,
    message_type,
    pose_message,
    set_camera_info_service,
)
from fsm_calib.robots.ros1.node import Node
from fsm_calib.robots.ros1.topics import Topics
from fsm_calib.robots.served.duckiebot import RESOLUTION, ServedDuckiebot
from fsm_calib.robots.served.settings import ServeSettings
from fsm_calib.robots.served.station import Station
from fsm_calib.types import Pose2, WheelCalibration, WheelCommand
from fsm_calib.world2d.robot import World

PARAMETERS = ("gain", "trim", "baseline", "radius", "k", "limit", "v_max", "omega_max")
"""Parameters of Duckietown's kinematics_node that its service saves."""


class ServedNode:
    """The served robot on a ROS network.

    Parameters
    ----------
    world : World
        The simulated world.
    settings : ServeSettings
        Delays and losses.
    master : str
        The master's URL.
    vehicle : str
        What topics begin with.
    encode : callable
        Returns an image (uint8) as JPEG bytes.
    lockstep : bool
        Time passes only when a client asks for it; else as on the wall.

    Raises
    ------
    LinkLost
        The master does not answer.
    """

    def __init__(
        self,
        world: World,
        settings: ServeSettings,
        master: str,
        vehicle: str,
        encode: Callable[[NDArray[np.uint8]], bytes],
        lockstep: bool = False,
    ) -> None:
        self.node = Node(f"/{vehicle}/duckiebot", master)
        self.topics, self._encode, self._lockstep = Topics(vehicle), encode, lockstep
        self.saved: dict[str, Any] = {}
        self.station = Station(world, settings, self, lockstep)
        self._offset = 0.0 if lockstep else time.time()
        self._parameters()
        self._publish()
        self._listen()
        self.station.start()

    @property
    def robot(self) -> ServedDuckiebot:
        """The robot that is served."""
        return self.station.robot

    @property
    def last_received(self) -> WheelCommand:
        """The wheel command that arrived last."""
        return self.station.last_received

    def _parameters(self) -> None:
        """Set the kinematics as a robot has them from the factory."""
        wheels = WheelCalibration()
        values = (1.0, 0.0, wheels.axle_length, wheels.wheel_radius, wheels.motor_constant, 1.0, 1.0, 8.0)
        for name, value in zip(PARAMETERS, values, strict=True):
            self.node.master.call("setParam", self.node.name, f"{self.topics.kinematics}/{name}", value)

    def _publish(self) -> None:
        """Begin to publish, and offer the services."""
        node, topics = self.node, self.topics
        self._image = node.publish(topics.image, IMAGE)
        self._executed = node.publish(topics.executed, WHEELS)
        self._encoders = {
            "left": node.publish(topics.left_tick, TICK),
            "right": node.publish(topics.right_tick, TICK),
        }
        self._stepped = node.publish(topics.stepped, TEXT)
        self._tracker = node.publish(topics.tracker, POSE)
        if self._lockstep:  # recorders then stamp what they hear with the robot's time
            node.master.call("setParam", node.name, "/use_sim_time", True)
            self._clock = node.publish("/clock", CLOCK)
        node.offer(topics.save_calibration, EMPTY_SERVICE, self._save)
        node.offer(topics.set_camera_info, set_camera_info_service(), self._set_camera)

    def _listen(self) -> None:
        """Begin to listen."""
        self.node.subscribe(self.topics.wheels, WHEELS, self._take)
        self.node.subscribe(self.topics.emergency_stop, BOOL, self._stop)
        self.node.subscribe(self.topics.step, TEXT, self._step)

    def _take(self, body: bytes) -> None:
        """A wheel command arrives."""
        message = message_type(WHEELS).decode(body)
        self.station.take(WheelCommand(float(message.vel_left), float(message.vel_right)))

    def _stop(self, body: bytes) -> None:
        """The emergency stop is pressed or released."""
        self.station.stop(bool(message_type(BOOL).decode(body).data))

    def _step(self, body: bytes) -> None:
        """Let time pass as a client in lockstep asks, and answer."""
        text = message_type(TEXT)
        self.station.step(
            json.loads(text.decode(body).data),
            lambda said: self._tell_step(json.dumps(said)),
        )

    def _tell_step(self, said: str) -> None:
        if self._lockstep:
            self._clock.publish(message_type(CLOCK).make(clock=header(self.robot.now).stamp))
        self._stepped.publish(message_type(TEXT).make(data=said))

    def _stamp(self, time: float) -> float:
        """Return what the robot's clock shows at its world's time [s]."""
        return self._offset + self.station.stood + time

    def frame(self, number: int, stamp: float, image: NDArray[np.uint8]) -> None:
        """Publish a frame; see `served.duckiebot.Outlet`."""
        data = np.frombuffer(self._encode(image), dtype=np.uint8)
        kind = message_type(IMAGE)
        self._image.publish(kind.stamped(self._stamp(stamp), number, "camera", format="jpeg", data=data))

    def executed(self, command: WheelCommand, number: int, time: float) -> None:
        """Tell that a command has been applied; see `served.duckiebot.Outlet`."""
        kind = message_type(WHEELS)
        self._executed.publish(
            kind.stamped(self._stamp(time), number, vel_left=command.left, vel_right=command.right)
        )

    def ticks(self, side: str, count: int, time: float) -> None:
        """Publish an encoder's count; see `served.duckiebot.Outlet`."""
        kind = message_type(TICK)
        self._encoders[side].publish(
            kind.stamped(self._stamp(time), 0, data=count, resolution=RESOLUTION, type=1)
        )

    def tracked(self, pose: Pose2, time: float) -> None:
        """Publish what a camera over the area measures; see `served.duckiebot.Outlet`."""
        self._tracker.publish(pose_message(self._stamp(time), pose.x, pose.y, pose.theta))

    def _save(self, request: bytes) -> bytes:
        """Keep the kinematics parameters, as the robot's service writes them to its file."""
        master, base = self.node.master, self.topics.kinematics
        self.saved["kinematics"] = {
            name: master.call("getParam", self.node.name, f"{base}/{name}") for name in PARAMETERS
        }
        return b""

    def _set_camera(self, request: bytes) -> bytes:
        """Keep the camera's calibration; answers ``bool success, string status_message``."""
        info = message_type(CAMERA_INFO).decode(request)
        if info.width == 0 or len(info.D) == 0:
            raise LinkLost("the camera calibration is empty")
        self.saved["camera"] = info
        return b"\x01\x00\x00\x00\x00"

    def close(self) -> None:
        """End it."""
        self.station.close()
        self.node.close()
