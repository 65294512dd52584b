"""Write a recording: as a manifest with CSV files, as a ROS 1 bag, or as a ROS 2 bag of MCAP or SQLite.

What is written reads back equal: CSV numbers keep 17 digits, and a bag carries every channel in full
precision in our own message beside Duckietown's messages (32-bit commands, whole ticks), which other tools
know.
"""

from __future__ import annotations

import csv
import gzip
import io
import json
import math
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2

from fsm_calib.errors import InputError
from fsm_calib.recording.channels import Channel, PoseTrack, StateTrack, WheelPair
from fsm_calib.recording.duckietown_messages import (
    CHANNEL_TYPE,
    POSE_TYPE,
    STATE_TYPE,
    TICK_TYPE,
    WHEELS_TYPE,
    writing_store,
)
from fsm_calib.recording.manifest_schema import FORMAT
from fsm_calib.recording.places import MANIFEST_NAME
from fsm_calib.recording.recording import Recording

TOPIC = "/fsm_calib/{}"
HEAD_TOPIC = TOPIC.format("recording")
BAG_EPOCH = 1_000_000_000_000_000_000  # ns: time 0 of a recording in a bag, so that no stamp is negative
GZIP_LEVEL = 6  # 9 takes twice as long for files 2 % smaller
CHANNEL_KEYS = {"twist": "command"}
COLUMNS = {
    "wheel_angle": {"unit": "rad"},
    "wheel_rate": {"unit": "rad/s"},
    "wheel_speed": {"unit": "m/s"},
    "yaw_rate": {"unit": "rad/s"},
    "twist": {"unit": "twist"},
}


def write_recording(recording: Recording, folder: Path, compress: bool = True) -> Path:
    """Write ``recording.yaml`` and one CSV file for each channel into `folder`; return the
    manifest's path.
    """
    folder.mkdir(parents=True, exist_ok=True)
    suffix = ".csv.gz" if compress else ".csv"
    sections: dict[str, Any] = {}
    for name, channel in recording.channels.items():
        file = f"{name}{suffix if name != 'state' else '.csv'}"
        _write_table(folder / file, channel)
        sections[CHANNEL_KEYS.get(name, name)] = {"file": file} | _section(name, channel)
    facts = {key: value for key, value in asdict(recording.robot).items() if value is not None}
    manifest = {"format": FORMAT, "robot": facts, "channels": sections}
    path = folder / MANIFEST_NAME
    path.write_text(
        yaml.safe_dump(manifest, sort_keys=False, default_flow_style=None, width=200), encoding="utf-8"
    )
    return path


def _arrays(channel: Channel) -> dict[str, Any]:
    """Return the columns of a channel by name; a heading that was never measured is left out."""
    columns = {f.name: getattr(channel, f.name) for f in fields(channel)}
    columns = {name: value for name, value in columns.items() if isinstance(value, np.ndarray | tuple)}
    if isinstance(channel, PoseTrack) and not channel.has_heading:
        del columns["theta"]
    return columns


def _section(name: str, channel: Channel) -> dict[str, Any]:
    columns = _arrays(channel)
    section: dict[str, Any] = {{"path": "state"}.get(key, key): key for key in columns}
    if "duration" in columns:
        # an interval channel's times follow from its durations
        del section["time"]
    section |= COLUMNS.get(name, {})
    if isinstance(channel, WheelPair) and name == "wheel_angle":
        section |= {"unit": "tick"} if channel.unit == "tick" else {}
        if channel.unit == "rad" and channel.resolution:
            section |= {"unit": "tick", "ticks_per_turn": 2.0 * math.pi / channel.resolution}
    for key in ("unit", "stale_after", "of", "stamp"):
        value = getattr(channel, key, None)
        if value is not None and key not in section:
            section[key] = value
    return section


def _write_table(path: Path, channel: Channel) -> None:
    """Write one CSV; wheel angles with a resolution go in ticks, whole numbers where they were ticks."""
    columns = _arrays(channel)
    if isinstance(channel, WheelPair) and channel.unit == "rad" and channel.resolution:
        columns = columns | {side: _ticks(columns[side], channel.resolution) for side in ("left", "right")}
    if "duration" in columns:
        del columns["time"]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*(_cells(column) for column in columns.values()), strict=True))
    data = text.getvalue().encode("utf-8")
    # no time stamp in the archive: the same recording gives the same bytes
    path.write_bytes(gzip.compress(data, GZIP_LEVEL, mtime=0) if path.suffix == ".gz" else data)


def _ticks(angle: np.ndarray, resolution: float) -> np.ndarray:
    """Return angles in ticks such that ticks * resolution gives the same angles back."""
    ticks = angle / resolution
    whole = np.round(ticks)
    return np.where(whole * resolution == angle, whole, ticks)


def _cells(column: Any) -> list[str] | list[float]:
    """Return a column's values; the csv module writes numbers with all their digits."""
    return list(column) if isinstance(column, tuple) else column.tolist()


def write_bag(recording: Recording, path: Path, prefix: str = "/robot") -> Path:
    """Write a ROS 1 bag (`path` ends in .bag) or else a ROS 2 bag folder with MCAP storage; return the path.

    `prefix` is the vehicle's name space of Duckietown's topics.
    """
    if path.exists():
        raise InputError(
            "the bag exists already", where=str(path), cure="Name a new file or remove this one."
        )
    ros1 = path.suffix == ".bag"
    store = writing_store(ros1)
    serialize = store.serialize_ros1 if ros1 else store.serialize_cdr
    writer = Writer1(path) if ros1 else Writer2(path, version=9, storage_plugin=StoragePlugin.MCAP)
    with writer:
        connections: dict[str, Any] = {}
        for time, topic, kind, values in _messages(recording, prefix):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            stamp = BAG_EPOCH + round(time * 1e9)
            message = store.types[kind](header=_header(store, stamp), **values)
            writer.write(connections[topic], stamp, serialize(message, kind))
    return path


Row = tuple[float, str, str, dict[str, Any]]
"""Time [s], topic, type and fields of a message but for its header; made a message when it is written, because
tens of thousands of message objects keep the garbage collector busy for as long as writing them takes."""


def _messages(recording: Recording, prefix: str) -> list[Row]:
    """Return everything in order of time."""
    about = {name: _channel_head(channel) for name, channel in recording.channels.items()}
    head = {"format": FORMAT, "robot": asdict(recording.robot), "channels": about}
    found: list[Row] = []
    for name, channel in recording.channels.items():
        found += _own_messages(name, channel)
    found += _duckietown_messages(recording, prefix)
    found.sort(key=lambda item: item[0])
    start = min([item[0] for item in found], default=0.0)
    return [(start, HEAD_TOPIC, CHANNEL_TYPE, {"values": np.empty(0), "text": json.dumps(head)}), *found]


def _channel_head(channel: Channel) -> dict[str, Any]:
    """Return what is no column: names of the columns, units, settings."""
    plain = {f.name: getattr(channel, f.name) for f in fields(channel)}
    columns = [name for name, value in plain.items() if isinstance(value, np.ndarray)]
    rest = {name: value for name, value in plain.items() if not isinstance(value, np.ndarray | tuple)}
    return {"kind": type(channel).__name__, "columns": columns, "settings": rest}


def _own_messages(name: str, channel: Channel) -> list[Row]:
    arrays = [getattr(channel, f.name) for f in fields(channel)]
    rows = np.stack([array for array in arrays if isinstance(array, np.ndarray)], axis=1, dtype=np.float64)
    words = channel.path if isinstance(channel, StateTrack) else ("",) * len(rows)
    topic, times = TOPIC.format(name), rows[:, 0].tolist()
    return [
        (time, topic, CHANNEL_TYPE, {"values": row, "text": word})
        for time, row, word in zip(times, rows, words, strict=True)
    ]


def _header(store: Any, stamp: int) -> Any:
    """Return the header of a message of time `stamp` [ns]."""
    seconds, nanoseconds = divmod(stamp, 1_000_000_000)
    time = store.types["builtin_interfaces/msg/Time"](sec=seconds, nanosec=nanoseconds)
    header = store.types["std_msgs/msg/Header"]
    extra = {"seq": 0} if "seq" in header.__dataclass_fields__ else {}
    return header(stamp=time, frame_id="world", **extra)


def _duckietown_messages(recording: Recording, prefix: str) -> list[Row]:
    """Return the same drive in Duckietown's own messages, as far as they can hold it."""
    found: list[Row] = []

    def add(time: float, topic: str, kind: str, **values: Any) -> None:
        found.append((time, f"{prefix}/{topic}", kind, values))

    command, angle = recording.command, recording.wheel_angle
    if command is not None and command.unit == "normalized":
        for time, left, right in zip(command.time, command.left, command.right, strict=True):
            add(
                float(time),
                "wheels_driver_node/wheels_cmd_executed",
                WHEELS_TYPE,
                vel_left=float(left),
                vel_right=float(right),
            )
    if angle is not None and angle.unit == "rad" and angle.resolution:
        turn = round(2.0 * math.pi / angle.resolution)
        for side in ("left", "right"):
            for time, value in zip(angle.time, getattr(angle, side), strict=True):
                ticks = round(float(value) / angle.resolution)
                add(
                    float(time),
                    f"{side}_wheel_encoder_node/tick",
                    TICK_TYPE,
                    data=ticks,
                    resolution=turn,
                    type=1,
                )
    if recording.pose is not None:
        columns = (getattr(recording.pose, key).tolist() for key in ("time", "x", "y", "theta"))
        for time, x, y, theta in zip(*columns, strict=True):
            add(time, "localization_node/pose", POSE_TYPE, x=x, y=y, theta=theta)
    if recording.state is not None:
        for time, path in zip(recording.state.time, recording.state.path, strict=True):
            add(float(time), "fsm_node/mode", STATE_TYPE, state=path)
    return found
