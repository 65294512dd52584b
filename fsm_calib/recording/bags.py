"""Read ROS 1 bags, ROS 2 bag folders and bare MCAP files.

A bag that `write_bag` wrote holds every channel in full precision and reads back equal. In any other bag
Duckietown's topics are known by type and name (docs/recordings.md lists them); time [s] is the message's
header stamp, counted from the first stamp in the bag. Duckietown's dead-reckoned poses are computed from
commands, measure nothing, and are left out.
"""

from __future__ import annotations

import json
import math
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np

from fsm_calib.errors import InputError
from fsm_calib.recording import channels as kinds
from fsm_calib.recording.bag_images import poses_from_bag_images
from fsm_calib.recording.bag_reader import BagReader
from fsm_calib.recording.channels import (
    CommandTrack,
    PoseTrack,
    StateTrack,
    TwistTrack,
    WheelPair,
    YawRateTrack,
)
from fsm_calib.recording.checks import checked
from fsm_calib.recording.duckietown_messages import typestore
from fsm_calib.recording.recording import CHANNELS, Finding, Recording, RobotFacts
from fsm_calib.recording.stamps import zero_told
from fsm_calib.recording.tag_poses import TagMap, TagRow, poses_from_tags, rows_of_message
from fsm_calib.recording.writers import HEAD_TOPIC, TOPIC

COMMAND_TOPICS = ("wheels_driver_node/wheels_cmd_executed", "wheels_driver_node/wheels_cmd", "wheels_cmd")
COMPUTED_POSES = ("deadreckoning", "velocity_to_pose", "odom")
WANTED = (
    "WheelsCmdStamped", "WheelEncoderStamped", "Twist2DStamped", "Pose2DStamped", "PoseStamped", "FSMState",
    "Imu",
    "AprilTagDetectionArray", "ChannelRow", "CameraInfo",
)  # fmt: skip


class Source:
    """Where a row of a bag came from, for error messages: the bag."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def where(self, row: int) -> str:
        """Return the bag and the number of the message."""
        return f"{self.path}: message {row + 1}"


def read_bag(path: Path, tag_map: TagMap | None = None) -> Recording:
    """Read a bag.

    Raises
    ------
    InputError
        The bag is damaged, cut short or holds no known topic.
    """
    topics = _read_topics(path)
    source = Source(path)
    try:
        if HEAD_TOPIC in topics:
            recording = _own(path, topics)
        else:
            recording = _duckietown(path, topics, tag_map)
        return checked(recording, {name: source for name in CHANNELS})
    except (LookupError, TypeError, ValueError, AttributeError, ArithmeticError, RecursionError) as error:
        problem = f"the bag's messages are damaged ({type(error).__name__})"
        raise InputError(problem, where=f"{path}:1", cure="Record it again.") from error


def _read_topics(path: Path) -> dict[str, list[tuple[int, str, Any]]]:
    """Return (stamp [ns], type, message) of every wanted message by topic."""
    topics: dict[str, list[tuple[int, str, Any]]] = defaultdict(list)
    try:
        with BagReader([path], default_typestore=typestore()) as reader:
            wanted = [c for c in reader.connections if c.msgtype.split("/")[-1] in WANTED]
            for connection, stamp, raw in reader.messages(connections=wanted):
                message = reader.deserialize(raw, connection.msgtype)
                topics[connection.topic].append((_stamp(message, stamp), connection.msgtype, message))
            known = sorted({connection.topic for connection in reader.connections})
    except Exception as error:  # a damaged bag can fail anywhere inside its reader
        raise InputError(
            f"the bag is damaged or cut short: {' '.join(str(error).split())[:200] or type(error).__name__}",
            where=f"{path}:1",
            cure="Record it again, or repair it with: rosbag reindex",
        ) from error
    if not topics:
        listed = ", ".join(known[:8]) or "none"
        raise InputError(f"the bag holds no topic that tells of a drive; topics: {listed}", where=f"{path}:1")
    return topics


def _stamp(message: Any, bag_time: int) -> int:
    """Return the header's stamp [ns], or the bag's own where there is none or it is zero."""
    header = getattr(message, "header", None)
    if header is None or (header.stamp.sec == 0 and header.stamp.nanosec == 0):
        return bag_time
    return int(header.stamp.sec) * 1_000_000_000 + int(header.stamp.nanosec)


def _own(path: Path, topics: dict[str, list[tuple[int, str, Any]]]) -> Recording:
    """Rebuild a recording that `write_bag` wrote."""
    try:
        head = json.loads(topics[HEAD_TOPIC][0][2].text)
        found: dict[str, Any] = {}
        for name, about in head["channels"].items():
            rows = [message for _, _, message in topics.get(TOPIC.format(name), [])]
            if not rows:
                continue
            table = np.stack([row.values for row in rows])
            columns: dict[str, Any] = {key: table[:, i] for i, key in enumerate(about["columns"])}
            if about["kind"] == "StateTrack":
                columns["path"] = tuple(row.text for row in rows)
            found[name] = getattr(kinds, about["kind"])(**columns, **about["settings"])
        facts = RobotFacts(**head["robot"])
    except (ValueError, LookupError, TypeError, AttributeError, RecursionError) as error:
        raise InputError("the bag's description of its channels is damaged", where=f"{path}:1") from error
    return Recording(robot=facts, source=str(path), **found)


def _duckietown(
    path: Path, topics: dict[str, list[tuple[int, str, Any]]], tag_map: TagMap | None
) -> Recording:
    """Read Duckietown's topics."""
    start = min(rows[0][0] for rows in topics.values())
    of_type: dict[str, dict[str, list[tuple[float, Any]]]] = defaultdict(dict)
    for topic, rows in topics.items():
        of_type[rows[0][1].split("/")[-1]][topic] = [
            ((stamp - start) / 1e9, message) for stamp, _, message in rows
        ]
    found: dict[str, Any] = {}
    command = _first_of(of_type["WheelsCmdStamped"], COMMAND_TOPICS)
    if command:
        time, left, right = _columns(command, "vel_left", "vel_right")
        found["command"] = CommandTrack(time, left, right)
    elif twists := _first_of(of_type["Twist2DStamped"], ("car_cmd_switch_node/cmd", "car_cmd")):
        time, v, omega = _columns(twists, "v", "omega")
        found["twist"] = TwistTrack(time, v, omega)
    angle = _encoders(of_type["WheelEncoderStamped"])
    if angle is not None:
        found["wheel_angle"] = angle
    if pose := _poses(of_type):
        found["pose"] = PoseTrack(*pose)
    if states := _first_of(of_type["FSMState"], ("fsm_node/mode",)):
        found["state"] = StateTrack(np.array([t for t, _ in states]), tuple(m.state for _, m in states))
    if turns := _first_of(of_type["Imu"], ("imu",)):
        values = np.array([m.angular_velocity.z for _, m in turns])
        found["yaw_rate"] = YawRateTrack(np.array([t for t, _ in turns]), values)
    findings: list[Finding] = zero_told(start / 1e9)
    if "pose" not in found and of_type["AprilTagDetectionArray"]:
        findings += _add_tag_poses(found, of_type["AprilTagDetectionArray"], tag_map)
    elif "pose" not in found and tag_map is not None:
        track, finding = poses_from_bag_images(path, tag_map, start / 1e9)
        found |= {} if track is None else {"pose": track}
        findings.append(finding)
    name = next((topic.split("/")[1] for topic in topics if topic.count("/") > 1), "robot")
    return Recording(
        robot=RobotFacts(name=name), source=str(path), checks=tuple(findings), clock_zero=start / 1e9, **found
    )


def _first_of(topics: dict[str, list[Any]], order: tuple[str, ...]) -> list[Any]:
    """Return the messages of the first topic whose name ends as `order` says, else of any topic."""
    for ending in order:
        for topic, rows in topics.items():
            if topic.endswith(ending):
                return rows
    return next(iter(topics.values()), [])


def _columns(rows: list[tuple[float, Any]], *names: str) -> list[np.ndarray]:
    time = np.array([t for t, _ in rows])
    return [time, *(np.array([float(getattr(m, name)) for _, m in rows]) for name in names)]


def _poses(of_type: dict[str, dict[str, list[tuple[float, Any]]]]) -> list[np.ndarray]:
    measured = {k: v for k, v in of_type["Pose2DStamped"].items() if not any(w in k for w in COMPUTED_POSES)}
    if measured:
        return _columns(next(iter(measured.values())), "x", "y", "theta")
    stamped = next(iter(of_type["PoseStamped"].values()), [])
    if not stamped:
        return []
    poses = [(t, m.pose.position, m.pose.orientation) for t, m in stamped]
    theta = [math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y**2 + q.z**2)) for _, _, q in poses]
    return [
        np.array(c)
        for c in ([t for t, _, _ in poses], [p.x for _, p, _ in poses], [p.y for _, p, _ in poses], theta)
    ]


def _encoders(topics: dict[str, list[tuple[float, Any]]]) -> WheelPair | None:
    """Return wheel angles [rad] at the left encoder's times; the right one is interpolated unless in step."""
    sides = {}
    for side in ("left", "right"):
        rows = next((rows for topic, rows in topics.items() if side in topic), [])
        if len(rows) < 2:
            return None
        time, data = _columns(rows, "data")
        order = np.argsort(time, kind="stable")
        sides[side] = (time[order], data[order] * 2.0 * math.pi / max(int(rows[0][1].resolution), 1))
    time, left = sides["left"]
    right = sides["right"][1] if np.array_equal(time, sides["right"][0]) else np.interp(time, *sides["right"])
    step = 2.0 * math.pi / max(int(next(iter(topics.values()))[0][1].resolution), 1)
    return WheelPair(time, left, right, "rad", step)


def _add_tag_poses(
    found: dict[str, Any], topics: dict[str, list[tuple[float, Any]]], tag_map: TagMap | None
) -> list[Finding]:
    """Turn tag detections into poses where a map of the tags was given."""
    rows: list[TagRow] = [row for t, m in _first_of(topics, ()) for row in rows_of_message(t, m)]
    if tag_map is None:
        return [
            Finding(
                "pose", "no_map", f"{len(rows)} tag detections are not used: no map of the tags was given"
            )
        ]
    track, finding = poses_from_tags(rows, tag_map)
    if track is not None:
        found["pose"] = track
    return [finding]
