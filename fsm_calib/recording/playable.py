"""A drive to be driven: commands as a CSV file, and as ROS 1 and ROS 2 bags that a robot can be played.

A bag repeats every command, because drivers and guards stop a robot that hears nothing (0.3 s of silence is enough
for ours). It holds the topic that the wheels' driver listens to, not the one on which it says what it did:

    rosbag play drive.bag        ros2 bag play drive_ros2
"""

from __future__ import annotations

import csv
import io
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2

from fsm_calib.errors import InputError
from fsm_calib.recording.duckietown_messages import WHEELS_TYPE, typestore
from fsm_calib.types import FloatArray

EVERY = 0.05  # s between repeats: 20 Hz, as Duckietown's own nodes send
TWIST_TYPE = "duckietown_msgs/msg/Twist2DStamped"
TOPICS = {
    "normalized": ("wheels_driver_node/wheels_cmd", WHEELS_TYPE, ("vel_left", "vel_right")),
    "twist": ("car_cmd_switch_node/cmd", TWIST_TYPE, ("v", "omega")),
}
COLUMNS = {"normalized": ("left", "right"), "rad/s": ("left", "right"), "twist": ("v", "omega")}
Unit = Literal["normalized", "rad/s", "twist"]


@dataclass(frozen=True, eq=False)
class Commands:
    """Held commands: from time [s] on the pair `values` (n, 2) in `unit`; the last row is zero.

    normalized: left, right [1]; rad/s: left, right; twist: v [m/s], omega [rad/s].
    """

    time: FloatArray
    values: FloatArray
    unit: Unit = "normalized"

    def repeated(self) -> tuple[FloatArray, FloatArray]:
        """Return times [s] every `EVERY` and at each change, and what holds then, (m, 2)."""
        end = float(self.time[-1]) + 1.0
        time = np.unique(np.round(np.concatenate([np.arange(0.0, end, EVERY), self.time]), 6))
        row = np.clip(np.searchsorted(self.time, time, side="right") - 1, 0, None)
        return time, self.values[row]


def write_playable(commands: Commands, folder: Path, prefix: str = "/robot") -> list[Path]:
    """Write ``commands.csv``, and ``drive.bag`` and ``drive_ros2`` for commands that Duckietown has a message for.

    `prefix` is the vehicle's name space. What an earlier plan left is replaced. Returns the paths.

    Raises
    ------
    InputError
        The folder cannot be written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        table = folder / "commands.csv"
        table.write_text(_csv(commands), encoding="utf-8")
        if commands.unit not in TOPICS:
            return [table]
        old, new = folder / "drive.bag", folder / "drive_ros2"
        old.unlink(missing_ok=True)
        shutil.rmtree(new, ignore_errors=True)
        for path in (old, new):
            _write_bag(commands, path, prefix)
    except OSError as error:
        raise InputError(f"the drive cannot be written: {error.strerror}", where=str(folder)) from error
    return [table, old, new]


def _csv(commands: Commands) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(("time", *COLUMNS[commands.unit]))
    for time, (first, second) in zip(commands.time, commands.values, strict=True):
        writer.writerow((f"{time:.6g}", f"{first:.6g}", f"{second:.6g}"))
    return text.getvalue()


def _write_bag(commands: Commands, path: Path, prefix: str) -> None:
    ros1 = path.suffix == ".bag"
    store, (topic, kind, names) = typestore(ros1), TOPICS[commands.unit]
    serialize = store.serialize_ros1 if ros1 else store.serialize_cdr
    writer: Any = Writer1(path) if ros1 else Writer2(path, version=9, storage_plugin=StoragePlugin.MCAP)
    with writer:
        connection = writer.add_connection(f"{prefix}/{topic}", kind, typestore=store)
        for time, pair in zip(*commands.repeated(), strict=True):
            stamp = round(float(time) * 1e9) + 1_000_000_000
            values = dict(zip(names, map(float, pair), strict=True))
            message = store.types[kind](header=_header(store, stamp), **values)
            writer.write(connection, stamp, serialize(message, kind))


def _header(store: Any, stamp: int) -> Any:
    seconds, nanoseconds = divmod(stamp, 1_000_000_000)
    header = store.types["std_msgs/msg/Header"]
    extra = {"seq": 0} if "seq" in header.__dataclass_fields__ else {}
    time = store.types["builtin_interfaces/msg/Time"](sec=seconds, nanosec=nanoseconds)
    return header(stamp=time, frame_id="", **extra)
