"""Bags as ROS robots write them: a simulated drive in the messages of a TurtleBot3 with a motion capture beside it."""

import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

from fsm_calib.recording import Recording
from fsm_calib.recording.recording import held_at

EPOCH = 1_700_000_000_000_000_000  # ns
STORAGES = {"ros1": None, "sqlite": StoragePlugin.SQLITE3, "mcap": StoragePlugin.MCAP}


class BagWriter:
    """Writes messages given as nested dicts, in order of time."""

    def __init__(self, storage: str) -> None:
        self.storage = STORAGES[storage]
        self.store = get_typestore(Stores.ROS1_NOETIC if self.storage is None else Stores.ROS2_HUMBLE)
        self.rows = []

    def add(self, time, topic, kind, stamp=None, **values):
        """Add a message recorded at `time` [s]; its header says `stamp` [s], the same unless given."""
        self.rows.append((round(time * 1e9), topic, kind, time if stamp is None else stamp, values))

    def built(self, kind, stamp, values):
        """Return a message with default fields but for `values`."""
        cls = self.store.types[kind]
        fields = {}
        for name, (node, of) in self.store.fielddefs[kind][1]:
            fields[name] = values[name] if name in values else self._default(int(node), of)
        if "header" in fields:
            fields["header"] = self.header(stamp, values.get("frame_id", "world"), values.get("seq", 0))
        return cls(**fields)

    def _default(self, node, of):
        if node == 1:
            return {"string": "", "bool": False}.get(of[0], 0)
        if node == 2:
            return self.built(of, 0.0, {})
        if node == 3:
            return np.zeros(of[1])
        return np.zeros(0)

    def header(self, stamp, frame, seq=0):
        """Return the header of time `stamp` [s] after the epoch; ROS 1 numbers it."""
        seconds, nanoseconds = divmod(EPOCH + round(stamp * 1e9), 1_000_000_000)
        time = self.store.types["builtin_interfaces/msg/Time"](sec=seconds, nanosec=nanoseconds)
        header = self.store.types["std_msgs/msg/Header"]
        extra = {"seq": seq} if "seq" in header.__dataclass_fields__ else {}
        return header(stamp=time, frame_id=frame, **extra)

    def write(self, path):
        """Write the bag; return its path."""
        ros1 = self.storage is None
        path = path.with_suffix(".bag") if ros1 else path
        writer = Writer1(path) if ros1 else Writer2(path, version=9, storage_plugin=self.storage)
        with writer:
            connections = {}
            for time, topic, kind, stamp, values in sorted(self.rows, key=lambda row: row[0]):
                if topic not in connections:
                    connections[topic] = writer.add_connection(topic, kind, typestore=self.store)
                message = self.built(kind, stamp, values)
                raw = (
                    self.store.serialize_ros1(message, kind)
                    if ros1
                    else self.store.serialize_cdr(message, kind)
                )
                writer.write(connections[topic], EPOCH + time, raw)
        return path

    def pose(self, x, y, theta):
        """Return a Pose in the plane."""
        t = self.store.types
        return t["geometry_msgs/msg/Pose"](
            t["geometry_msgs/msg/Point"](x, y, 0.02),
            t["geometry_msgs/msg/Quaternion"](0.0, 0.0, np.sin(theta / 2), np.cos(theta / 2)),
        )

    def twist(self, v, omega):
        """Return a Twist in the plane."""
        vector = self.store.types["geometry_msgs/msg/Vector3"]
        return self.store.types["geometry_msgs/msg/Twist"](vector(v, 0.0, 0.0), vector(0.0, 0.0, omega))


def command_rows(twist):
    """Return the commands of a drive as a driver repeats them, ten times a second."""
    time = np.arange(0.0, twist.time[-1] + 1.0, 0.1)
    at = time + 1e-6
    return time, held_at(at, twist.time, twist.v), held_at(at, twist.time, twist.omega)


def turtlebot(recording: Recording, storage: str) -> BagWriter:
    """Return a TurtleBot3's bag of a drive: cmd_vel, odom, joint_states, imu, a motion capture and a goal."""
    bag = BagWriter(storage)
    for time, v, omega in zip(*command_rows(recording.twist), strict=True):
        bag.add(time, "/cmd_vel", "geometry_msgs/msg/Twist", **_fields(bag.twist(v, omega)))
    pose = recording.pose
    for time, x, y, theta in zip(pose.time, pose.x, pose.y, pose.theta, strict=True):
        bag.add(
            time + 0.004, "/vrpn/tb3/pose", "geometry_msgs/msg/PoseStamped", time, pose=bag.pose(x, y, theta)
        )
    for time in np.arange(0.5, pose.time[-1], 4.0):
        bag.add(time, "/goal_pose", "geometry_msgs/msg/PoseStamped", pose=bag.pose(1.0, 2.0, 0.0))
    wheels = recording.wheel_angle
    if wheels is not None:
        for time, left, right in zip(wheels.time, wheels.left, wheels.right, strict=True):
            joints = {"name": ["wheel_left_joint", "wheel_right_joint"], "position": np.array([left, right])}
            bag.add(time + 0.002, "/joint_states", "sensor_msgs/msg/JointState", time, **joints)
    return bag


def _fields(message):
    return {name: getattr(message, name) for name in message.__dataclass_fields__ if name != "__msgtype__"}
