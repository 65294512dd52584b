"""Stores a calibration on a Duckiebot with ROS 1, by Duckietown's own services, and reads it back."""

from __future__ import annotations

import struct
from typing import Any

import numpy as np

from fsm_calib.errors import LinkLost
from fsm_calib.robots.ros1.messages import (
    CAMERA_INFO,
    EMPTY_SERVICE,
    UPDATE_SERVICE,
    header,
    message_type,
    set_camera_info_service,
)
from fsm_calib.robots.ros1.node import Node
from fsm_calib.robots.ros1.topics import Topics
from fsm_calib.types import CameraModel, WheelCalibration

TOLERANCE = 1e-9
"""A parameter that is read back differs by no more [1]."""


def store_calibration(
    node: Node, topics: Topics, camera: CameraModel | None, wheels: WheelCalibration | None
) -> list[str]:
    """Store what was found and return what was stored, a sentence each.

    Raises
    ------
    LinkLost
        A service refuses, or a parameter that is read back is another one.
    """
    said = []
    if wheels is not None:
        _store_wheels(node, topics, wheels)
        said.append(f"Its kinematics hold trim {wheels.trim:.4f} and are saved.")
    if camera is not None:
        _store_camera(node, topics, camera)
        said.append("Its camera calibration is saved; the camera reads it at its next start.")
    return said


def _store_wheels(node: Node, topics: Topics, wheels: WheelCalibration) -> None:
    """Set gain and trim, save them by the robot's service, and read them back."""
    wanted = {"gain": wheels.gain, "trim": wheels.trim}
    for name, value in wanted.items():
        node.master.call("setParam", node.name, f"{topics.kinematics}/{name}", float(value))
        _make_known(node, topics, f"{topics.kinematics}/{name}")
    node.call_service(topics.save_calibration, EMPTY_SERVICE, b"")
    for name, value in wanted.items():
        read = float(node.master.call("getParam", node.name, f"{topics.kinematics}/{name}"))
        if abs(read - value) > TOLERANCE:
            raise LinkLost(f"{topics.kinematics}/{name} is {read}, not {value}", cure="Set it by hand.")


def _make_known(node: Node, topics: Topics, parameter: str) -> None:
    """Have the kinematics node read a parameter now.

    The master tells it of a change a moment later, and some of Duckietown's versions save what they were told last.
    """
    if node.is_offered(topics.update_parameters):
        name = parameter.encode()
        node.call_service(topics.update_parameters, UPDATE_SERVICE, struct.pack("<I", len(name)) + name)


def _store_camera(node: Node, topics: Topics, camera: CameraModel) -> None:
    """Give the camera its calibration by its service."""
    request = message_type(CAMERA_INFO).encode(camera_info(camera))
    answer = node.call_service(topics.set_camera_info, set_camera_info_service(), request)
    if answer[:1] != b"\x01":
        (size,) = struct.unpack_from("<I", answer, 1) if len(answer) >= 5 else (0,)
        why = answer[5 : 5 + size].decode(errors="replace")
        raise LinkLost(f"{topics.set_camera_info} refuses: {why}", cure="Copy the file by hand.")


def camera_info(camera: CameraModel) -> Any:
    """Return a camera as sensor_msgs/CameraInfo; rectification is none, the projection is the matrix."""
    kind = message_type(CAMERA_INFO)
    region = message_type("sensor_msgs/RegionOfInterest").make(
        x_offset=0, y_offset=0, height=0, width=0, do_rectify=False
    )
    projection = np.hstack([camera.matrix, np.zeros((3, 1))])
    return kind.make(
        header=header(0.0),
        height=camera.height,
        width=camera.width,
        distortion_model=camera.model,
        D=np.array(camera.distortion),
        K=np.array(camera.matrix).ravel(),
        R=np.eye(3).ravel(),
        P=projection.ravel(),
        binning_x=0,
        binning_y=0,
        roi=region,
    )
