"""ROS's own messages as rows of numbers: poses, twists, joints, turn rates, states.

Each function takes (time [s], message) rows of one topic. Poses come from any message that holds one; quaternions
become headings, and one of norm zero is a heading that was not measured.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from fsm_calib.errors import InputError
from fsm_calib.recording.channels import PoseTrack, StateTrack, TwistTrack, WheelPair, YawRateTrack
from fsm_calib.types import FloatArray

Rows = Sequence[tuple[float, Any]]
POSES = (
    "Pose2DStamped", "PoseStamped", "PoseWithCovarianceStamped", "TransformStamped", "TFMessage", "Odometry",
)  # fmt: skip
TWISTS = ("Twist2DStamped", "Twist", "TwistStamped")
WHEELS = ("JointState", "WheelEncoderStamped", "Odometry")
TURNS = ("Imu",)
STATES = ("FSMState", "String")
STILL = 1e-9  # rad: joints whose angle never changes by more hold no angle, only the rates count


def time_of(rows: Rows) -> FloatArray:
    """Return the times [s] of rows."""
    return np.array([time for time, _ in rows], dtype=float)


def heading_of(q: Any) -> float:
    """Return the heading [rad] of a quaternion, counter-clockwise about z; NaN for none."""
    norm = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z
    if not 0.0 < norm < math.inf:
        return math.nan
    return math.atan2(2 * (q.w * q.z + q.x * q.y) / norm, 1 - 2 * (q.y**2 + q.z**2) / norm)


def _pose_row(message: Any) -> tuple[float, float, float]:
    """Return x, y [m], theta [rad] of whatever holds a pose."""
    if hasattr(message, "theta"):
        return float(message.x), float(message.y), float(message.theta)
    if hasattr(message, "transform"):
        place, turn = message.transform.translation, message.transform.rotation
    else:
        pose = message.pose
        pose = getattr(pose, "pose", pose)
        place, turn = pose.position, pose.orientation
    return float(place.x), float(place.y), heading_of(turn)


def pose_track(rows: Rows) -> PoseTrack:
    """Return the poses of any topic of `POSES`."""
    x, y, theta = np.array([_pose_row(message) for _, message in rows], dtype=float).T
    return PoseTrack(time_of(rows), x, y, theta)


def numbers_of(rows: Rows) -> list[int]:
    """Return the numbers that a publisher gave its messages; zeros where there are none, as in ROS 2."""
    return [int(getattr(getattr(message, "header", None), "seq", 0)) for _, message in rows]


def twist_track(rows: Rows) -> TwistTrack:
    """Return the commanded speeds of any topic of `TWISTS`."""
    pairs = []
    for _, message in rows:
        if hasattr(message, "omega"):
            pairs.append((message.v, message.omega))
            continue
        twist: Any = getattr(message, "twist", message)
        pairs.append((twist.linear.x, twist.angular.z))
    v, omega = np.array(pairs, dtype=float).T
    return TwistTrack(time_of(rows), v, omega)


def yaw_rate_track(rows: Rows) -> YawRateTrack:
    """Return the turn rates about z of an IMU."""
    return YawRateTrack(time_of(rows), np.array([m.angular_velocity.z for _, m in rows], dtype=float))


def state_track(rows: Rows) -> StateTrack:
    """Return the states of an FSMState or a String; of a JSON object its `path` or `state`."""
    return StateTrack(time_of(rows), tuple(_state_of(message) for _, message in rows))


def _state_of(message: Any) -> str:
    text = str(getattr(message, "state", getattr(message, "data", "")))
    if not text.startswith("{"):
        return text
    try:
        plain = json.loads(text)
        return str(plain.get("path", plain.get("state", text)))
    except (ValueError, RecursionError):
        return text


def joint_wheels(rows: Rows, where: str, joints: tuple[str, str] | None = None) -> tuple[str, WheelPair]:
    """Return the channel (wheel_angle or wheel_rate) and the wheels of a JointState topic.

    joints : names of the left and the right joint; None: all joints whose name says left or right, those that say
    wheel first; several on one side are averaged, as the wheels of a skid-steered robot turn together.

    Raises
    ------
    InputError
        No joint of a side is found.
    """
    names = list(rows[0][1].name)
    sides = [_of_side(names, side, joints[i] if joints else None) for i, side in enumerate(("left", "right"))]
    if not all(sides):
        raise InputError(
            f"no left and right wheel among the joints {', '.join(names) or '(none)'}",
            where=where,
            cure="Name them in a manifest: wheel_angle: {topic: TOPIC, left: JOINT, right: JOINT}.",
        )
    rows = [
        row for row in rows if list(row[1].name) == names
    ]  # a broadcaster of other joints shares the topic
    for channel, unit, field in (("wheel_angle", "rad", "position"), ("wheel_rate", "rad/s", "velocity")):
        if all(len(getattr(m, field)) == len(names) for _, m in rows):
            table = np.array([getattr(m, field) for _, m in rows], dtype=float)
            left, right = (table[:, side].mean(axis=1) for side in sides)
            if field == "velocity" or max(np.ptp(left), np.ptp(right)) > STILL:
                return channel, WheelPair(time_of(rows), left, right, unit)
    raise InputError("the joints hold neither positions nor velocities", where=where)


def _of_side(names: list[str], side: str, given: str | None) -> list[int]:
    if given is not None:
        return [i for i, name in enumerate(names) if name == given]
    found = [
        i for i, name in enumerate(names) if side in name.lower() or name.lower().startswith(f"{side[0]}_")
    ]
    wheels = [i for i in found if "wheel" in names[i].lower()]
    return wheels or found


def odometry_wheels(rows: Rows, axle: float | None, where: str) -> WheelPair:
    """Return the rim speeds [m/s] that an odometry's twist says, v -+ omega b / 2 with axle length b [m].

    Raises
    ------
    InputError
        The axle length is not known.
    """
    if axle is None:
        raise InputError(
            "an odometry's twist becomes wheel speeds only with the axle length",
            where=where,
            cure="Give --urdf FILE, or a manifest with robot: {axle_length: METRES}.",
        )
    twists = np.array([(m.twist.twist.linear.x, m.twist.twist.angular.z) for _, m in rows], dtype=float)
    half = 0.5 * axle * twists[:, 1]
    return WheelPair(time_of(rows), twists[:, 0] - half, twists[:, 0] + half, "m/s")


def encoder_wheels(topics: dict[str, Rows]) -> WheelPair | None:
    """Return wheel angles [rad] at the left encoder's times; the right one is interpolated unless in step."""
    sides = {}
    for side in ("left", "right"):
        rows = next((rows for topic, rows in topics.items() if side in topic), [])
        if len(rows) < 2:
            return None
        time, data = time_of(rows), np.array([float(m.data) for _, m in rows])
        order = np.argsort(time, kind="stable")
        sides[side] = (time[order], data[order] * 2.0 * math.pi / max(int(rows[0][1].resolution), 1))
    time, left = sides["left"]
    right = sides["right"][1] if np.array_equal(time, sides["right"][0]) else np.interp(time, *sides["right"])
    step = 2.0 * math.pi / max(int(next(iter(topics.values()))[0][1].resolution), 1)
    return WheelPair(time, left, right, "rad", step)
