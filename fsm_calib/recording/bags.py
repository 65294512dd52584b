"""Read ROS 1 bags, ROS 2 bag folders and bare MCAP files.

A bag that `write_bag` wrote holds every channel in full precision and reads back equal. In any other bag topics are
known by type and name (docs/recordings.md lists them), or named by the user; time [s] counts from the first stamp.
Dead-reckoned poses are computed from commands or wheels, measure nothing, and are left out unless they are named.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fsm_calib.errors import InputError
from fsm_calib.recording import channels as kinds
from fsm_calib.recording import ros_messages as ros
from fsm_calib.recording.bag_images import poses_from_bag_images
from fsm_calib.recording.bag_topics import read_topics
from fsm_calib.recording.channels import CommandTrack
from fsm_calib.recording.checks import checked
from fsm_calib.recording.named import NOTHING, Named
from fsm_calib.recording.recording import CHANNELS, Finding, Recording, RobotFacts
from fsm_calib.recording.stamps import zero_told
from fsm_calib.recording.tag_poses import TagMap, TagRow, poses_from_tags, rows_of_message
from fsm_calib.recording.topics import (
    MEASURED,
    Topic,
    chosen,
    commanded,
    first_of,
    measured_pose,
    owner_of,
    passed_over,
    says,
)
from fsm_calib.recording.undirected import directed
from fsm_calib.recording.unknown_commands import lost_before
from fsm_calib.recording.writers import HEAD_TOPIC, TOPIC

COMMAND_TOPICS = ("wheels_driver_node/wheels_cmd_executed", "wheels_driver_node/wheels_cmd", "wheels_cmd")
SECOND = 1e9  # ns


class Source:
    """Where a row of a bag came from, for error messages: the bag."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def where(self, row: int) -> str:
        """Return the bag and the number of the message."""
        return f"{self.path}: message {row + 1}"


def read_bag(path: Path, tag_map: TagMap | None = None, named: Named = NOTHING) -> Recording:
    """Read a bag.

    Raises
    ------
    InputError
        The bag is damaged, cut short or holds no known topic; a named topic is not there or cannot serve; several could
        be the pose or the command.
    """
    topics, findings = read_topics(path)
    source = Source(path)
    try:
        own = HEAD_TOPIC in topics and not named.any_topic
        recording = _own(path, topics) if own else _any_bag(path, topics, tag_map, named)
        recording = replace(recording, checks=(*findings, *recording.checks))
        return checked(recording, {name: source for name in CHANNELS}, stated=None if own else ())
    except (LookupError, TypeError, ValueError, AttributeError, ArithmeticError, RecursionError) as error:
        problem = f"the bag's messages are damaged ({type(error).__name__})"
        raise InputError(problem, where=f"{path}:1", cure="Record it again.") from error


def _own(path: Path, topics: dict[str, Topic]) -> Recording:
    """Rebuild a recording that `write_bag` wrote."""
    try:
        head = json.loads(topics[HEAD_TOPIC].rows[0][1].text)
        found: dict[str, Any] = {}
        for name, about in head["channels"].items():
            topic = topics.get(TOPIC.format(name))
            if topic is None:
                continue
            rows = [message for _, message in topic.rows]
            table = np.stack([row.values for row in rows])
            columns: dict[str, Any] = {key: table[:, i] for i, key in enumerate(about["columns"])}
            if about["kind"] == "StateTrack":
                columns["path"] = tuple(row.text for row in rows)
            found[name] = getattr(kinds, about["kind"])(**columns, **about["settings"])
        facts = RobotFacts(**head["robot"])
    except (ValueError, LookupError, TypeError, AttributeError, RecursionError) as error:
        raise InputError("the bag's description of its channels is damaged", where=f"{path}:1") from error
    return Recording(robot=facts, source=str(path), **found)


def _any_bag(path: Path, topics: dict[str, Topic], tag_map: TagMap | None, named: Named) -> Recording:
    """Return the channels that the topics of a bag tell, named or known."""
    where = str(path)
    used = _used(topics, named, where)
    facts = named.robot or RobotFacts()
    if facts.name == RobotFacts().name:
        facts = replace(facts, name=_owner(used, topics) or facts.name)
    start = min((topic.rows[0][0] for topic in topics.values()), default=0)
    findings = zero_told(start / SECOND) + _told(used)
    found = _channels(used, start, named, facts, where)
    angles = ros.encoder_wheels(
        {t.name: _since(t, start) for t in topics.values() if t.kind == "WheelEncoderStamped"}
    )
    if angles is not None and not named.wheels:
        command = found.get("command")
        found["wheel_angle"] = angles if command is None else directed(angles, command)
    tags = first_of(topics, "AprilTagDetectionArray")
    if "pose" not in found and tags is not None:
        findings += _add_tag_poses(found, _since(tags, start), tag_map)
    elif "pose" not in found and tag_map is not None:
        track, finding = poses_from_bag_images(path, tag_map, start / SECOND)
        found |= {} if track is None else {"pose": track}
        findings.append(finding)
    if "pose" not in found:
        findings += _passed_over(topics)
    if not found:
        raise InputError(f"no topic tells of a drive; the bag holds {_all(topics)}", where=where)
    return Recording(robot=facts, source=where, checks=tuple(findings), clock_zero=start / SECOND, **found)


def _owner(used: dict[str, Topic], topics: dict[str, Topic]) -> str:
    """Return whose drive it is: whom the pose is of, else whose nodes were recorded; empty where no name says it."""
    names = [used["pose"].name] if "pose" in used else []
    names += [topic.name for topic in topics.values() if not says(topic, MEASURED)]
    return next(filter(None, map(owner_of, names)), "")


def _passed_over(topics: dict[str, Topic]) -> list[Finding]:
    """Return a sentence where topics hold poses that are computed, as it seems, and the option that takes one."""
    poses = passed_over(topics, ros.POSES)
    if not poses:
        return []
    said = (
        f"none was read: {', '.join(map(str, poses))} seems computed by the robot, which measures nothing; if it is "
        f"measured: --pose {poses[0].name}"
    )
    return [Finding("pose", "topic", said, "kept", 0, 0.0)]


def _used(topics: dict[str, Topic], named: Named, where: str) -> dict[str, Topic]:
    """Return the topic of each channel: as named, else as known."""
    used: dict[str, Topic | None] = {
        "pose": measured_pose(topics, ros.POSES, where)
        if named.pose is None
        else chosen(topics, named.pose, "pose", ros.POSES, where)
    }
    if named.command is not None:
        used["command"] = chosen(topics, named.command, "command", ("WheelsCmdStamped", *ros.TWISTS), where)
    else:
        used["command"] = first_of(topics, "WheelsCmdStamped", COMMAND_TOPICS) or commanded(
            topics, ros.TWISTS, where
        )
    if named.wheels is not None:
        used["wheels"] = chosen(topics, named.wheels, "wheels", ros.WHEELS, where)
    else:
        used["wheels"] = first_of(topics, "JointState", ("joint_states",))
    used["yaw_rate"] = (
        chosen(topics, named.yaw_rate, "yaw_rate", ros.TURNS, where)
        if named.yaw_rate
        else first_of(topics, "Imu", ("imu", "imu/data"))
    )
    used["state"] = (
        chosen(topics, named.state, "state", ros.STATES, where)
        if named.state
        else first_of(topics, "FSMState", ("fsm_node/mode",)) or _fsm_state(topics)
    )
    return {channel: topic for channel, topic in used.items() if topic is not None}


def topics_used(topics: dict[str, Topic], where: str) -> tuple[dict[str, Topic], list[str]]:
    """Return the topics that are read where none is named, and the sentences where several could be."""
    doubts = []
    for choose, kinds_of in ((measured_pose, ros.POSES), (commanded, ros.TWISTS)):
        try:
            choose(topics, kinds_of, where)
        except InputError as error:
            doubts.append(error.problem)
            topics = {n: t for n, t in topics.items() if t.kind not in kinds_of}
    return _used(topics, NOTHING, where), doubts


def _fsm_state(topics: dict[str, Topic]) -> Topic | None:
    """Return the topic on which this project's machine tells its state."""
    return next(
        (t for t in topics.values() if t.kind == "String" and t.name.endswith("fsm_calib/state")), None
    )


def _channels(
    used: dict[str, Topic], start: int, named: Named, facts: RobotFacts, where: str
) -> dict[str, Any]:
    """Return the channels of the topics, times [s] counted from `start` [ns]."""
    found: dict[str, Any] = {}
    rows = {channel: _since(topic, start) for channel, topic in used.items()}
    if "command" in used and used["command"].kind == "WheelsCmdStamped":
        left, right = (
            np.array([float(getattr(m, f"vel_{s}")) for _, m in rows["command"]]) for s in ("left", "right")
        )
        found["command"] = CommandTrack(ros.time_of(rows["command"]), left, right)
    elif "command" in used:
        found["twist"] = ros.twist_track(rows["command"])
    for name in {"command", "twist"} & set(found):
        lost = lost_before(ros.numbers_of(rows["command"]))
        found[name] = replace(found[name], stale_after=named.stale_after, lost=lost)
    if "pose" in used:
        found["pose"] = ros.pose_track(rows["pose"])
    if "wheels" in used and used["wheels"].kind == "JointState":
        found |= _joints(used["wheels"], rows["wheels"], named, where)
    elif "wheels" in used and used["wheels"].kind == "Odometry":
        found["wheel_speed"] = ros.odometry_wheels(rows["wheels"], facts.axle_length, where)
    for name in ("wheel_rate", "wheel_speed"):
        if name in found:
            found[name] = replace(found[name], stamp=named.stamp)
    if "yaw_rate" in used:
        found["yaw_rate"] = ros.yaw_rate_track(rows["yaw_rate"])
    if "state" in used:
        found["state"] = ros.state_track(rows["state"])
    return found


def _joints(topic: Topic, rows: ros.Rows, named: Named, where: str) -> dict[str, Any]:
    """Return the wheels of a topic of joints; one that nobody named may hold other joints (an arm)."""
    try:
        channel, pair = ros.joint_wheels(rows, f"{where}: {topic.name}", named.joints)
    except InputError:
        if named.wheels:
            raise
        return {}
    return {channel: pair}


def _since(topic: Topic, start: int) -> list[tuple[float, Any]]:
    return [((stamp - start) / SECOND, message) for stamp, message in topic.rows]


def _told(used: dict[str, Topic]) -> list[Finding]:
    """Tell which topic was read as which channel."""
    return [Finding(channel, "topic", f"read from {topic}") for channel, topic in used.items()]


def _all(topics: dict[str, Topic]) -> str:
    shown: Iterable[Topic] = list(topics.values())[:12]
    return ", ".join(map(str, shown)) or "none that is known"


def _add_tag_poses(found: dict[str, Any], messages: ros.Rows, tag_map: TagMap | None) -> list[Finding]:
    """Turn tag detections into poses where a map of the tags was given."""
    rows: list[TagRow] = [row for t, m in messages for row in rows_of_message(t, m)]
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
