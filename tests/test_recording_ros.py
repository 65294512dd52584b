"""ROS's own messages in bags: which topic is which channel, and what is said where nobody can know."""

import numpy as np
import pytest
from typer.testing import CliRunner
from wild_bags import BagWriter, turtlebot

from fsm_calib.cli import app
from fsm_calib.errors import InputError
from fsm_calib.recording import PoseTrack, Recording, TwistTrack, WheelPair, read_recording
from fsm_calib.recording.named import Named
from fsm_calib.recording.recording import RobotFacts
from fsm_calib.recording.topics import owner_of

TIME = np.arange(0.0, 6.0, 0.05)


def small() -> Recording:
    angle = np.linspace(0.0, 9.0, len(TIME))
    return Recording(
        twist=TwistTrack(np.array([0.3, 3.0]), np.array([0.1, 0.2]), np.array([0.0, 0.4])),
        pose=PoseTrack(TIME, 0.05 * TIME, 0.01 * TIME**2, 0.3 * np.sin(TIME)),
        wheel_angle=WheelPair(TIME, angle, 1.1 * angle),
    )


@pytest.mark.parametrize("storage", ["ros1", "sqlite", "mcap"])
def test_a_turtlebots_bag_needs_no_option(tmp_path, storage):
    found = read_recording(turtlebot(small(), storage).write(tmp_path / "drive"))
    assert found.pose.time == pytest.approx(TIME, abs=1e-6)
    assert found.pose.theta == pytest.approx(0.3 * np.sin(TIME), abs=1e-9)
    assert found.twist.v[-1] == pytest.approx(0.2)
    assert found.twist.omega[-1] == pytest.approx(0.4)
    assert found.wheel_angle.right == pytest.approx(1.1 * found.wheel_angle.left)
    assert found.clock_zero == pytest.approx(1.7e9)


def two_poses(tmp_path):
    bag = BagWriter("mcap")
    for time in TIME:
        for topic in ("/a/pose", "/b/pose"):
            bag.add(time, topic, "geometry_msgs/msg/PoseStamped", pose=bag.pose(time, 0.0, 0.0))
        bag.add(time, "/cmd_vel", "geometry_msgs/msg/TwistStamped", twist=bag.twist(0.2, 0.0))
    return bag.write(tmp_path / "two")


@pytest.mark.parametrize(
    ("topic", "robot"),
    [
        ("/autobot04/wheels_driver_node/wheels_cmd", "autobot04"),
        ("/vrpn_client_node/rob/pose", "rob"),
        ("/vrpn/tb3/pose", "tb3"),
        ("/cmd_vel", ""),
        ("/robot/camera/image", ""),
    ],
)
def test_a_topic_says_whose_it_is(topic, robot):
    assert owner_of(topic) == robot


def test_two_candidate_poses_are_listed_with_type_count_and_rate(tmp_path):
    with pytest.raises(InputError) as caught:
        read_recording(two_poses(tmp_path))
    said = str(caught.value)
    assert "2 topics could be the pose" in said
    assert "/a/pose (PoseStamped, 120 messages, 20 Hz), /b/pose (PoseStamped" in said
    assert "--pose /a/pose" in said


def test_a_pose_is_chosen_by_name(tmp_path):
    found = read_recording(two_poses(tmp_path), named=Named(pose="/b/pose"))
    assert len(found.pose) == len(TIME)
    assert found.twist.v[0] == pytest.approx(0.2)


def test_a_topic_that_is_not_there_lists_those_that_serve(tmp_path):
    ran = CliRunner().invoke(app, ["identify", str(two_poses(tmp_path)), "--pose", "/c/pose"])
    assert ran.exit_code == 2
    assert "no topic '/c/pose'; these would serve: /a/pose (PoseStamped" in " ".join(ran.stderr.split())


def test_a_topic_of_another_type_cannot_be_the_pose(tmp_path):
    with pytest.raises(InputError, match=r"/cmd_vel .* cannot serve as pose; these would serve: /a/pose"):
        read_recording(two_poses(tmp_path), named=Named(pose="/cmd_vel"))


def test_topics_of_a_manifest_over_a_bag(tmp_path):
    two_poses(tmp_path)
    (tmp_path / "r.yaml").write_text(
        "format: fsm-calib/recording@1\nbag: two\nrobot: {name: tim, axle_length: 0.2}\n"
        "channels: {pose: {topic: /a/pose}, command: {topic: /cmd_vel, stale_after: 0.5}}\n"
    )
    found = read_recording(tmp_path / "r.yaml")
    assert (found.robot.name, found.robot.axle_length, found.twist.stale_after) == ("tim", 0.2, 0.5)


def test_a_manifest_over_a_bag_that_is_not_there_is_refused_with_its_line(tmp_path):
    (tmp_path / "r.yaml").write_text("format: fsm-calib/recording@1\nbag: nothing.bag\n")
    with pytest.raises(InputError, match=r"r\.yaml:2:6: the bag 'nothing\.bag' does not exist"):
        read_recording(tmp_path / "r.yaml")


def test_topics_named_for_a_manifest_are_refused(tmp_path):
    (tmp_path / "r.yaml").write_text("format: fsm-calib/recording@1\nbag: x\n")
    with pytest.raises(InputError, match="names its channels itself"):
        read_recording(tmp_path / "r.yaml", named=Named(pose="/p"))


def test_transforms_of_a_motion_capture_are_poses_and_those_of_the_odometry_are_not(tmp_path):
    bag = BagWriter("sqlite")
    types = bag.store.types
    for time in TIME:
        parts = []
        for parent, child, x in (("odom", "base_footprint", 0.0), ("world", "robot", time)):
            place = types["geometry_msgs/msg/Vector3"](x, 0.0, 0.0)
            turn = types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
            moved = types["geometry_msgs/msg/Transform"](place, turn)
            parts.append(types["geometry_msgs/msg/TransformStamped"](bag.header(time, parent), child, moved))
        bag.add(time, "/tf", "tf2_msgs/msg/TFMessage", transforms=parts)
        bag.add(time, "/cmd_vel", "geometry_msgs/msg/Twist", **{"linear": bag.twist(1.0, 0.0).linear})
    found = read_recording(bag.write(tmp_path / "tf"))
    assert found.pose.x == pytest.approx(TIME, abs=1e-6)


def test_a_world_with_the_name_of_its_house_is_a_world(tmp_path):
    bag = BagWriter("mcap")
    types = bag.store.types
    for time in TIME:
        pose = bag.pose(time, 0.0, 0.0)
        place = types["geometry_msgs/msg/Vector3"](time, 0.0, 0.0)
        moved = types["geometry_msgs/msg/Transform"](place, pose.orientation)
        header = bag.header(time, "vicon/world")
        part = types["geometry_msgs/msg/TransformStamped"](header, "vicon/tb3/tb3", moved)
        bag.add(time, "/tf", "tf2_msgs/msg/TFMessage", transforms=[part])
    assert read_recording(bag.write(tmp_path / "tf")).pose.x == pytest.approx(TIME, abs=1e-6)


def test_poses_that_were_passed_over_are_told_with_the_option_that_takes_them(tmp_path):
    bag = BagWriter("ros1")
    for time in TIME:
        bag.add(time, "/odom", "nav_msgs/msg/Odometry")
        bag.add(time, "/cmd_vel", "geometry_msgs/msg/Twist", **{"linear": bag.twist(1.0, 0.0).linear})
    found = read_recording(bag.write(tmp_path / "odom"))
    assert any("if it is measured: --pose /odom" in str(finding) for finding in found.checks)


def test_an_odometry_measures_no_pose_but_its_twist_may_be_the_wheels(tmp_path):
    bag = BagWriter("ros1")
    for time in TIME:
        speeds = bag.store.types["geometry_msgs/msg/TwistWithCovariance"](bag.twist(0.3, 0.5), np.zeros(36))
        bag.add(time, "/odom", "nav_msgs/msg/Odometry", twist=speeds)
        bag.add(time, "/imu", "sensor_msgs/msg/Imu", angular_velocity=bag.twist(0.0, 0.5).angular)
    path = bag.write(tmp_path / "odom")
    assert read_recording(path).pose is None
    found = read_recording(path, named=Named(wheels="/odom", robot=RobotFacts(axle_length=0.4)))
    assert (found.wheel_speed.left[0], found.wheel_speed.right[0]) == pytest.approx((0.2, 0.4))
    assert found.yaw_rate.value[0] == pytest.approx(0.5)
    with pytest.raises(InputError, match="only with the axle length"):
        read_recording(path, named=Named(wheels="/odom"))


def test_headers_on_another_clock_are_moved_onto_the_recorders_and_told(tmp_path):
    bag = BagWriter("mcap")
    for time in TIME:
        bag.add(time, "/cmd_vel", "geometry_msgs/msg/Twist", **{"linear": bag.twist(1.0, 0.0).linear})
        bag.add(
            time, "/mocap/pose", "geometry_msgs/msg/PoseStamped", time - 3e8, pose=bag.pose(time, 0.0, 0.0)
        )
    found = read_recording(bag.write(tmp_path / "late"))
    assert found.pose.time == pytest.approx(found.twist.time, abs=1e-6)
    assert any("another clock" in str(finding) for finding in found.checks)


def test_four_driven_wheels_are_averaged_by_side(tmp_path):
    bag = BagWriter("mcap")
    names = ["front_left_wheel", "front_right_wheel", "rear_left_wheel", "rear_right_wheel"]
    for time in TIME:
        bag.add(
            time,
            "/joint_states",
            "sensor_msgs/msg/JointState",
            name=names,
            velocity=np.array([1.0, 2.0, 3.0, 4.0]),
        )
        bag.add(time, "/imu/data", "sensor_msgs/msg/Imu")
    found = read_recording(bag.write(tmp_path / "four"))
    assert (found.wheel_rate.left[0], found.wheel_rate.right[0]) == (2.0, 3.0)
