"""Message definitions that ROS itself does not ship: Duckietown's, and the one that carries our own channels.

ROS 1 bags and MCAP files carry their definitions; ROS 2 SQLite bags need them registered. Sources: dt-ros-
commons `packages/duckietown_msgs/msg` (2024), the old duckietown_msgs (2019) and apriltags2_ros, which all
three call a list of tags AprilTagDetectionArray and mean different things by it.
"""

from __future__ import annotations

from functools import lru_cache

from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

CHANNEL_TYPE = "fsm_calib_msgs/msg/ChannelRow"
WHEELS_TYPE = "duckietown_msgs/msg/WheelsCmdStamped"
TICK_TYPE = "duckietown_msgs/msg/WheelEncoderStamped"
STATE_TYPE = "duckietown_msgs/msg/FSMState"
POSE_TYPE = "duckietown_msgs/msg/Pose2DStamped"
STATES = (
    "LANE_FOLLOWING",
    "INTERSECTION_COORDINATION",
    "INTERSECTION_CONTROL",
    "NORMAL_JOYSTICK_CONTROL",
    "SAFE_JOYSTICK_CONTROL",
    "PARKING",
    "ARRIVE_AT_STOP_LINE",
    "LANE_RECOVERY",
    "INTERSECTION_RECOVERY",
    "CALIBRATING",
    "CALIBRATING_CALC",
)
"""Constants of FSMState, in their order: they count in a message's md5, by which nodes know each other's types.

ROS 1 keeps their quotes as part of the value, rosbags takes off one pair: hence two."""
HEADER = "std_msgs/Header header\n"
DEFINITIONS = {
    CHANNEL_TYPE: HEADER + "float64[] values\nstring text\n",
    WHEELS_TYPE: HEADER + "float32 vel_left\nfloat32 vel_right\n",
    TICK_TYPE: "uint8 ENCODER_TYPE_ABSOLUTE=0\nuint8 ENCODER_TYPE_INCREMENTAL=1\n"
    + HEADER
    + "int32 data\nuint16 resolution\nuint8 type\n",
    "duckietown_msgs/msg/Twist2DStamped": HEADER + "float32 v\nfloat32 omega\n",
    POSE_TYPE: HEADER + "float64 x\nfloat64 y\nfloat64 theta\n",
    "duckietown_msgs/msg/BoolStamped": HEADER + "bool data\n",
    STATE_TYPE: HEADER + "string state\n" + "".join(f"string {name}='\"{name}\"'\n" for name in STATES),
    "duckietown_msgs/msg/AprilTagDetection": "geometry_msgs/Transform transform\nint32 tag_id\n"
    "string tag_family\nint32 hamming\nfloat32 decision_margin\nfloat32[9] homography\nfloat32[2] center\n"
    "float32[8] corners\nfloat32 pose_error\n",
    "duckietown_msgs/msg/AprilTagDetectionArray": HEADER + "duckietown_msgs/AprilTagDetection[] detections\n",
    "apriltags2_ros/msg/AprilTagDetection": "int32[] id\nfloat64[] size\n"
    "geometry_msgs/PoseWithCovarianceStamped pose\n",
    "apriltags2_ros/msg/AprilTagDetectionArray": HEADER + "apriltags2_ros/AprilTagDetection[] detections\n",
}
TIME = {"builtin_interfaces/msg/Time": "int32 sec\nuint32 nanosec\n"}
STAMP = "builtin_interfaces/Time stamp\nstring frame_id\n"
WRITTEN = (CHANNEL_TYPE, WHEELS_TYPE, TICK_TYPE, POSE_TYPE, STATE_TYPE)
"""Types of the messages that a bag of ours holds."""
OLD_TAG_DEFINITIONS = {
    "duckietown_msgs/msg/AprilTagDetection": "int32 id\nfloat64 size\ngeometry_msgs/PoseStamped pose\n",
    "duckietown_msgs/msg/AprilTagDetectionArray": "duckietown_msgs/AprilTagDetection[] detections\n",
}
"""The old duckietown_msgs: no header on the list."""


@lru_cache(maxsize=4)
def typestore(ros1: bool = False, old_tags: bool = False) -> Typestore:
    """Return ROS's own message types with Duckietown's and ours added."""
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    types: dict = {}
    for name, text in (DEFINITIONS | (OLD_TAG_DEFINITIONS if old_tags else {})).items():
        types.update(get_types_from_msg(text, name))
    store.register(types)
    return store


@lru_cache(maxsize=2)
def writing_store(ros1: bool = False) -> Typestore:
    """Return the types that a bag of ours holds, and no others: all of ROS's take 0.1 s to load."""
    store = get_typestore(Stores.EMPTY)
    types: dict = {}
    header = {"std_msgs/msg/Header": "uint32 seq\n" + STAMP if ros1 else STAMP}
    for name, text in (TIME | header | {name: DEFINITIONS[name] for name in WRITTEN}).items():
        types.update(get_types_from_msg(text, name))
    store.register(types)
    return store
