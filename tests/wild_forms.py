"""Twelve recordings in the forms that other people's robots leave, of simulated drives whose robots are known.

Each form is written to a folder as its owner would have it; `Form.arguments` are what the owner gives to `identify` and
`diagnose`, with one option at most, and `Form.truth` holds what the recording can tell of the robot.
"""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from wild_bags import BagWriter, turtlebot

from fsm_calib.perception.rotations import base_from_camera
from fsm_calib.recording import PoseTrack, Recording, TwistTrack, WheelPair
from fsm_calib.types import CameraMount, Pose2
from fsm_calib.world2d.observation import predict
from fsm_calib.world2d.parameters import parameters
from fsm_calib.world2d.rollout import Drive

EPOCH = 1_700_000_000.0  # s
HEAD = "format: fsm-calib/recording@1\n"


@dataclass(frozen=True)
class Robot:
    """A robot that follows commanded twists: radius, axle [m], mass [kg], top speed and turn rate [m/s, rad/s]."""

    radius: float = 0.033
    axle: float = 0.16
    mass: float = 1.0
    speed: float = 0.2
    turn: float = 1.5

    def parameters(self):
        """Return the simulation's parameters; commands are rim speeds in m/s."""
        return parameters(
            {
                "gain_left": 1.0, "gain_right": 1.0, "axle_length": self.axle, "mass": self.mass,
                "wheel_radius_left": self.radius, "wheel_radius_right": self.radius,
            }
        )  # fmt: skip


@dataclass(frozen=True)
class Form:
    """One form: its name, what the commands are given, and what is true of the robot by estimate's name."""

    name: str
    arguments: list
    truth: dict


def driven(robot=Robot(), seed=0, duration=40.0, rate=20.0):
    """Return a drive of arcs, spins and rests with poses of a motion capture and exact wheel angles."""
    rng = np.random.default_rng(seed)
    time, v, omega, at = [], [], [], 0.5
    while at < duration - 1.0:
        kind = rng.integers(4)
        u = rng.uniform(0.4, 1.0) * (1 if rng.random() < 0.7 else -1)
        time.append(at)
        v.append(0.0 if kind == 1 else u * robot.speed)
        omega.append(0.0 if kind == 0 else rng.uniform(0.3, 1.0) * (1 if kind == 2 else -1) * robot.turn)
        at = round(at + rng.uniform(0.8, 2.0), 1)  # the driver sends at 10 Hz
    v[-1] = omega[-1] = 0.0
    v, omega = np.array(v), np.array(omega)
    half = 0.5 * robot.axle * omega
    stamps = np.arange(0.0, duration, 1.0 / rate)
    drive = Drive(time, v - half, v + half)
    seen = predict(robot.parameters(), drive, stamps, (0.2, -0.1, 0.3), wheel_times=stamps)
    noise = rng.normal(size=(len(stamps), 3)) * [0.001, 0.001, 0.004]
    return Recording(
        twist=TwistTrack(np.array(time), v, omega),
        pose=PoseTrack(stamps, *(seen.poses + noise).T),
        wheel_angle=WheelPair(stamps, *seen.wheel_angles.T),
    )


def table(path: Path, header: str, *columns):
    """Write a CSV file; columns of words stay as they are."""
    rows = (
        ",".join(c if isinstance(c, str) else f"{c:.9g}" for c in row) for row in zip(*columns, strict=True)
    )
    path.write_text(header + "\n" + "\n".join(rows) + "\n")
    return path


def epoch(times):
    """Return times as epoch seconds with all their digits."""
    return [f"{int(EPOCH + t // 1)}.{round((t % 1) * 1e6):06d}" for t in times]


def iso(times):
    """Return times as ISO 8601 words of one day."""
    return [f"2024-05-01T10:{int(t // 60):02d}:{t % 60:09.6f}Z" for t in times]


GAINS = {"forward_gain": 1.0, "turn_gain": 1.0}


def wheel_truth(robot):
    """Return what poses with wheels tell."""
    return {"wheel_radius_left": robot.radius, "wheel_radius_right": robot.radius, "axle_length": robot.axle}


def turtlebots(folder):
    """Yield a TurtleBot3's bag in three storages, a goal's poses beside the motion capture's."""
    for seed, storage in enumerate(("ros1", "sqlite", "mcap")):
        bag = turtlebot(driven(seed=seed), storage).write(folder / f"tb3_{storage}")
        yield Form(f"TurtleBot3, {storage}", [bag], wheel_truth(Robot()) | GAINS)


def epoch_table(folder):
    """Commanded twists and poses with epoch stamps."""
    r = driven(seed=3)
    table(folder / "cmd.csv", "t,v,w", epoch(r.twist.time), r.twist.v, r.twist.omega)
    table(folder / "pose.csv", "t,x,y,h", epoch(r.pose.time), r.pose.x, r.pose.y, r.pose.theta)
    text = "  command: {file: cmd.csv, time: t, v: v, omega: w, unit: twist}\n"
    return Form("epoch CSV", [manifest(folder, "epoch", text + POSE)], GAINS)


POSE = "  pose: {file: pose.csv, time: t, x: x, y: y, theta: h}\n"


def manifest(folder, name, channels, robot="{name: wild}"):
    """Write a manifest; return its path."""
    path = folder / f"{name}.recording.yaml"
    path.write_text(f"{HEAD}robot: {robot}\nchannels:\n{channels}")
    return path


def rpm_and_degrees(folder):
    """Wheel rates in rpm and headings in degrees, neither stated."""
    r = driven(seed=4)
    rpm = [
        np.gradient(side, r.wheel_angle.time) * 60.0 / (2.0 * math.pi)
        for side in (r.wheel_angle.left, r.wheel_angle.right)
    ]
    table(folder / "wheels.csv", "t,l,r", r.wheel_angle.time, *rpm)
    wrapped = (np.degrees(r.pose.theta) + 180.0) % 360.0 - 180.0
    table(folder / "pose.csv", "t,x,y,h", r.pose.time, r.pose.x, r.pose.y, wrapped)
    text = "  wheel_rate: {file: wheels.csv, time: t, left: l, right: r}\n" + POSE
    facts = "{name: wild, wheel_radius: 0.033, axle_length: 0.16}"
    return Form("rpm and degrees", [manifest(folder, "rpm", text, facts)], wheel_truth(Robot()))


def millimetres(folder):
    """ISO times and a motion capture in millimetres."""
    r = driven(seed=5)
    table(folder / "cmd.csv", "t,v,w", iso(r.twist.time), r.twist.v, r.twist.omega)
    table(folder / "pose.csv", "t,x,y,h", iso(r.pose.time), 1e3 * r.pose.x, 1e3 * r.pose.y, r.pose.theta)
    text = "  command: {file: cmd.csv, time: t, v: v, omega: w, unit: twist}\n"
    return Form("ISO times and millimetres", [manifest(folder, "mm", text + POSE)], GAINS)


MOUNT = CameraMount(forward=0.05, height=0.11, pitch=0.2)
TAGS = {
    k: Pose2(2.2 * math.cos(a), 2.2 * math.sin(a), a - math.pi / 2.0)
    for k, a in enumerate(np.arange(0.0, 6.2, 0.2))
}
"""Upright tags on a circle about the start, their prints facing its middle; theta = where it faces + a quarter turn."""


def quaternion_of(rotation):
    """Return the quaternion (x, y, z, w) of a rotation matrix."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(rotation).as_quat()


def upright_tags(folder):
    """A bag of tag detections; the tags stand upright, as Duckietown's signs do."""
    r = driven(seed=6, rate=8.0)
    bag = BagWriter("ros1")
    from fsm_calib.recording.duckietown_messages import typestore

    bag.store = typestore(ros1=True)
    turn, place = base_from_camera(MOUNT)
    rng = np.random.default_rng(6)
    for row, time in enumerate(r.pose.time):
        robot = r.pose.pose(row)
        found = []
        for number, tag in TAGS.items():
            local = robot.inverse().then(tag)
            if local.x < 0.3 or abs(math.atan2(local.y, local.x)) > 0.5:
                continue
            along = np.array([math.cos(local.theta), math.sin(local.theta), 0.0])
            down = np.array([0.0, 0.0, -1.0])
            rotation = turn.T @ np.column_stack([along, down, np.cross(along, down)])
            centre = turn.T @ (np.array([local.x, local.y, 0.12]) - place) + rng.normal(size=3) * 0.002
            found.append(detection(bag.store, number, centre, quaternion_of(rotation)))
        kind = "duckietown_msgs/msg/AprilTagDetectionArray"
        bag.add(time, "/bot/apriltag_detector_node/detections", kind, detections=found)
    for time, v, omega in zip(r.twist.time, r.twist.v, r.twist.omega, strict=True):
        bag.add(time, "/bot/car_cmd_switch_node/cmd", "duckietown_msgs/msg/Twist2DStamped", v=v, omega=omega)
    rows = [f"  {k}: {{x: {t.x}, y: {t.y}, faces: {t.theta - math.pi / 2.0}}}\n" for k, t in TAGS.items()]
    (folder / "tags.yaml").write_text(
        "mount: {forward: 0.05, height: 0.11, pitch: 0.2}\ntags:\n" + "".join(rows)
    )
    return Form("upright tags", [bag.write(folder / "tags"), "--tag-map", folder / "tags.yaml"], GAINS)


def detection(store, number, centre, q):
    """Return one detection of the current duckietown_msgs."""
    t = store.types
    moved = t["geometry_msgs/msg/Transform"](
        t["geometry_msgs/msg/Vector3"](*map(float, centre)), t["geometry_msgs/msg/Quaternion"](*map(float, q))
    )
    flat = (np.zeros(n, np.float32) for n in (9, 2, 8))
    return t["duckietown_msgs/msg/AprilTagDetection"](moved, number, "tag36h11", 0, 50.0, *flat, 0.0)


URDF = """<robot name="cart"><link name="base_link"><inertial><mass value="{m}"/><inertia izz="0.1"/></inertial></link>
<link name="left_wheel"><collision><geometry><cylinder radius="{r}" length="0.02"/></geometry></collision></link>
<link name="right_wheel"><collision><geometry><cylinder radius="{r}" length="0.02"/></geometry></collision></link>
<joint name="l" type="continuous"><parent link="base_link"/><child link="left_wheel"/><origin xyz="0 {y} 0"/></joint>
<joint name="r" type="continuous"><parent link="base_link"/><child link="right_wheel"/><origin xyz="0 -{y} 0"/></joint>
</robot>"""


def described(folder):
    """A bag whose robot is told by a URDF file."""
    robot = Robot(0.05, 0.24, 4.0, 0.3, 1.2)
    bag = turtlebot(driven(robot, 7), "mcap").write(folder / "cart")
    (folder / "cart.urdf").write_text(URDF.format(m=robot.mass, r=robot.radius, y=0.5 * robot.axle))
    return Form("URDF robot", [bag, "--urdf", folder / "cart.urdf"], wheel_truth(robot) | GAINS)


def heavy(folder):
    """A robot of 20 kg."""
    robot = Robot(0.1, 0.5, 20.0, 0.8, 1.2)
    return Form(
        "20 kg robot",
        [turtlebot(driven(robot, 8), "sqlite").write(folder / "heavy")],
        wheel_truth(robot) | GAINS,
    )


def two_clocks(folder):
    """Commands and poses logged by two computers, whose clocks differ by 37 s."""
    r = driven(seed=9)
    table(folder / "cmd.csv", "t,v,w", epoch(r.twist.time + 37.0), r.twist.v, r.twist.omega)
    table(folder / "pose.csv", "t,x,y,h", epoch(r.pose.time), r.pose.x, r.pose.y, r.pose.theta)
    text = "  command: {file: cmd.csv, time: t, v: v, omega: w, unit: twist}\n"
    return Form("two clocks", [manifest(folder, "clocks", text + POSE)], GAINS)


def transforms(folder):
    """A motion capture's transforms and an odometry's on one topic."""
    r = driven(seed=10)
    bag = BagWriter("mcap")
    t = bag.store.types
    for time, x, y, theta in zip(r.pose.time, r.pose.x, r.pose.y, r.pose.theta, strict=True):
        parts = []
        for parent, child, scale in (("world", "robot", 1.0), ("odom", "base_footprint", 0.9)):
            pose = bag.pose(scale * x, scale * y, theta)
            place = t["geometry_msgs/msg/Vector3"](pose.position.x, pose.position.y, 0.0)
            moved = t["geometry_msgs/msg/Transform"](place, pose.orientation)
            parts.append(t["geometry_msgs/msg/TransformStamped"](bag.header(time, parent), child, moved))
        bag.add(time, "/tf", "tf2_msgs/msg/TFMessage", transforms=parts)
    for time, v, omega in zip(r.twist.time, r.twist.v, r.twist.omega, strict=True):
        bag.add(time, "/cmd_vel", "geometry_msgs/msg/TwistStamped", twist=bag.twist(v, omega))
    return Form("transforms", [bag.write(folder / "tf")], GAINS)


def two_poses(folder):
    """Two trackers, one of them of another robot; the owner names the right one."""
    r = driven(seed=11)
    bag = turtlebot(r, "ros1")
    for time in r.pose.time:
        bag.add(
            time, "/vrpn/other/pose", "geometry_msgs/msg/PoseStamped", pose=bag.pose(0.1 * time, 1.0, 0.0)
        )
    path = bag.write(folder / "two")
    return Form("two tracked robots", [path, "--pose", "/vrpn/tb3/pose"], wheel_truth(Robot()) | GAINS)


SINGLE = {
    f.__name__: f
    for f in (
        epoch_table, rpm_and_degrees, millimetres, upright_tags, described, heavy, two_clocks, transforms, two_poses,
    )
}  # fmt: skip


def all_forms(folder: Path):
    """Write all twelve below `folder`; return them."""
    (folder / "tb3").mkdir(parents=True)
    forms = list(turtlebots(folder / "tb3"))
    for name, make in SINGLE.items():
        (folder / name).mkdir()
        forms.append(make(folder / name))
    return forms
