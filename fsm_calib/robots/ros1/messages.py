"""Messages of ROS 1 and Duckietown: how they are written as bytes, and the md5 by which nodes know a type."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

from fsm_calib.recording.duckietown_messages import typestore

WHEELS = "duckietown_msgs/WheelsCmdStamped"
TICK = "duckietown_msgs/WheelEncoderStamped"
BOOL = "duckietown_msgs/BoolStamped"
TWIST = "duckietown_msgs/Twist2DStamped"
MODE = "duckietown_msgs/FSMState"
IMAGE = "sensor_msgs/CompressedImage"
CAMERA_INFO = "sensor_msgs/CameraInfo"
TEXT = "std_msgs/String"
POSE = "geometry_msgs/PoseStamped"
CLOCK = "rosgraph_msgs/Clock"


@dataclass(frozen=True)
class MessageType:
    """A type of messages, named as ROS 1 does: ``package/Name``."""

    name: str

    @property
    def _long(self) -> str:
        package, _, name = self.name.partition("/")
        return f"{package}/msg/{name}"

    @cached_property
    def _definition(self) -> tuple[str, str]:
        return typestore(ros1=True).generate_msgdef(self._long, ros_version=1)

    @property
    def definition(self) -> str:
        """The full text of the definition, with the types in it."""
        return self._definition[0]

    @property
    def md5(self) -> str:
        """The md5 of the definition, as ROS 1 computes it."""
        return self._definition[1]

    def make(self, **fields: Any) -> Any:
        """Return a message with these fields."""
        return typestore(ros1=True).types[self._long](**fields)

    def stamped(self, time: float, seq: int = 0, frame: str = "", **fields: Any) -> Any:
        """Return a message with a header; `time` is ROS time [s]."""
        return self.make(header=header(time, seq, frame), **fields)

    def encode(self, message: Any) -> bytes:
        """Return a message as bytes."""
        return bytes(typestore(ros1=True).serialize_ros1(message, self._long))

    def decode(self, body: bytes) -> Any:
        """Return the message in `body`."""
        return typestore(ros1=True).deserialize_ros1(body, self._long)


@lru_cache
def message_type(name: str) -> MessageType:
    """Return the type called `name`, made once: its definition takes a while."""
    return MessageType(name)


def header(time: float, seq: int = 0, frame: str = "") -> Any:
    """Return a ROS 1 header with `time` [s]."""
    types = typestore(ros1=True).types
    whole, rest = divmod(round(time * 1e9), 1_000_000_000)
    stamp = types["builtin_interfaces/msg/Time"](sec=whole, nanosec=rest)
    return types["std_msgs/msg/Header"](seq=seq, stamp=stamp, frame_id=frame)


def pose_message(time: float, x: float, y: float, theta: float) -> Any:
    """Return a planar pose [m, m, rad] as geometry_msgs/PoseStamped in the frame `map`."""
    types = typestore(ros1=True).types
    position = types["geometry_msgs/msg/Point"](x=x, y=y, z=0.0)
    turn = types["geometry_msgs/msg/Quaternion"](
        x=0.0, y=0.0, z=math.sin(theta / 2.0), w=math.cos(theta / 2.0)
    )
    pose = types["geometry_msgs/msg/Pose"](position=position, orientation=turn)
    return message_type(POSE).stamped(time, 0, "map", pose=pose)


def stamp_of(message: Any) -> float:
    """Return the time [s] in a message's header."""
    return float(message.header.stamp.sec) + 1e-9 * float(message.header.stamp.nanosec)


@dataclass(frozen=True)
class ServiceType:
    """A type of services: name and md5; requests and answers are bytes."""

    name: str
    md5: str


EMPTY_SERVICE = ServiceType("std_srvs/Empty", hashlib.md5(b"", usedforsecurity=False).hexdigest())
UPDATE_SERVICE = ServiceType("duckietown_msgs/NodeRequestParamsUpdate", "*")
"""A parameter's name in, a bool out; its md5 is not the same in all versions, and ROS takes any."""


@lru_cache
def set_camera_info_service() -> ServiceType:
    """Return sensor_msgs/SetCameraInfo: a CameraInfo, answered by ``bool success, string status_message``."""
    request = f"{message_type(CAMERA_INFO).md5} camera_info"
    answer = "bool success\nstring status_message"
    digest = hashlib.md5((request + answer).encode(), usedforsecurity=False).hexdigest()
    return ServiceType("sensor_msgs/SetCameraInfo", digest)
