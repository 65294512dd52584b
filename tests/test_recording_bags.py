"""ROS 1 bags, ROS 2 bags and MCAP files."""

import re
import sqlite3
from contextlib import closing

import numpy as np
import pytest
from recording_samples import every_channel
from rosbags.rosbag1 import ReaderError
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2

from fsm_calib.errors import InputError
from fsm_calib.recording import read_recording
from fsm_calib.recording.duckietown_messages import typestore
from fsm_calib.recording.tag_poses import rows_of_message
from fsm_calib.recording.writers import write_bag


@pytest.mark.parametrize("twist", [False, True])
@pytest.mark.parametrize("name", ["drive.bag", "drive"])
def test_written_bag_reads_back_equal(tmp_path, name, twist):
    recording = every_channel(5, twist)
    assert read_recording(write_bag(recording, tmp_path / name)) == recording


def test_bare_mcap_reads_back_equal(tmp_path):
    recording = every_channel(6)
    folder = write_bag(recording, tmp_path / "drive")
    assert read_recording(next(folder.glob("*.mcap"))) == recording


def message(store, kind, time, **values):
    header = store.types["std_msgs/msg/Header"]
    extra = {"seq": 0} if "seq" in header.__dataclass_fields__ else {}
    stamp = store.types["builtin_interfaces/msg/Time"](sec=100 + int(time), nanosec=round(time % 1 * 1e9))
    return store.types[kind](header=header(stamp=stamp, frame_id="", **extra), **values)


DUCKIETOWN = (
    ("/bot/wheels_driver_node/wheels_cmd", "WheelsCmdStamped", [{"vel_left": 0.25, "vel_right": 0.5}]),
    (
        "/bot/left_wheel_encoder_node/tick",
        "WheelEncoderStamped",
        [{"data": k, "resolution": 135, "type": 1} for k in (0, 27)],
    ),
    (
        "/bot/right_wheel_encoder_node/tick",
        "WheelEncoderStamped",
        [{"data": k, "resolution": 135, "type": 1} for k in (5, 54)],
    ),
    ("/bot/fsm_node/mode", "FSMState", [{"state": "LANE_FOLLOWING"}]),
    ("/bot/velocity_to_pose_node/pose", "Pose2DStamped", [{"x": 1.0, "y": 1.0, "theta": 1.0}]),
)


def write_duckietown(path, storage=None):
    store = typestore(ros1=storage is None)
    writer = Writer1(path) if storage is None else Writer2(path, version=8, storage_plugin=storage)
    with writer:
        for topic, name, rows in DUCKIETOWN:
            kind = f"duckietown_msgs/msg/{name}"
            connection = writer.add_connection(topic, kind, typestore=store)
            for k, values in enumerate(rows):
                built = message(store, kind, 0.5 * k, **values)
                raw = (
                    store.serialize_ros1(built, kind) if storage is None else store.serialize_cdr(built, kind)
                )
                writer.write(connection, 100_000_000_000 + k * 500_000_000, raw)


@pytest.mark.parametrize("storage", [None, StoragePlugin.SQLITE3, StoragePlugin.MCAP])
def test_duckietown_topics_become_channels(tmp_path, storage):
    path = tmp_path / ("bot.bag" if storage is None else "bot")
    write_duckietown(path, storage)
    recording = read_recording(path)
    assert recording.robot.name == "bot"
    assert (recording.command.left[0], recording.command.right[0]) == (0.25, 0.5)
    assert np.diff(recording.wheel_angle.left) == pytest.approx([2.0 * np.pi * 27 / 135])
    assert recording.wheel_angle.time == pytest.approx([0.0, 0.5])
    assert recording.state.path == ("LANE_FOLLOWING",)


def test_pose_computed_from_commands_is_no_measurement(tmp_path):
    write_duckietown(tmp_path / "bot.bag")
    assert read_recording(tmp_path / "bot.bag").pose is None


def test_truncated_bag_is_refused(tmp_path):
    path = write_bag(every_channel(), tmp_path / "drive.bag")
    path.write_bytes(path.read_bytes()[:-3000])
    with pytest.raises(InputError, match="damaged or cut short"):
        read_recording(path)


def test_what_a_bags_reader_says_ends_with_one_full_stop(tmp_path):
    (tmp_path / "drive.bag").write_bytes(b"no bag")
    with pytest.raises(InputError, match=r"cut short: [^.]*[^. ]\. Record it again"):
        read_recording(tmp_path / "drive.bag")


@pytest.mark.parametrize(
    ("raised", "said"),
    [
        (
            ReaderError("Bag index looks damaged: ('Header could not be read from file.',)"),
            "Bag index looks damaged: Header could not be read from file",
        ),
        (
            ReaderError("""Bag index looks damaged: ("Could not read string field 'topic'.",)"""),
            "Bag index looks damaged: Could not read string field 'topic'",
        ),
        (ReaderError("A metadata key is missing KeyError('version')."), "A metadata key is missing version"),
        (
            ReaderError("Some database files are missing: ['a (1).db3', 'b.db3']"),
            "Some database files are missing: a (1).db3, b.db3",
        ),
        (
            ReaderError("Serialization format {'xml'} is not supported."),
            "Serialization format xml is not supported",
        ),
        (ReaderError("unknown record", 7), "unknown record 7"),
        (ReaderError(), "ReaderError"),
    ],
)
def test_what_a_bags_reader_says_is_told_in_words(tmp_path, monkeypatch, raised, said):
    def fails(*_, **__):
        raise raised

    monkeypatch.setattr("fsm_calib.recording.bag_topics.BagReader", fails)
    path = write_bag(every_channel(), tmp_path / "drive.bag")
    with pytest.raises(InputError) as refused:
        read_recording(path)
    assert f"the bag is damaged or cut short: {said}. Record it again" in str(refused.value)


def test_a_cut_bag_is_refused_in_words_wherever_it_is_cut(tmp_path):
    path = write_bag(every_channel(), tmp_path / "drive.bag")
    whole = path.read_bytes()
    for left in range(100, len(whole), len(whole) // 40):
        path.write_bytes(whole[:left])
        with pytest.raises(InputError) as refused:
            read_recording(path)
        assert not re.search(r"""\(['"]|,\)""", str(refused.value))


def test_a_time_that_is_no_number_is_refused(tmp_path):
    write_duckietown(tmp_path / "bot", StoragePlugin.SQLITE3)
    (table,) = (tmp_path / "bot").glob("*.db3")
    with closing(sqlite3.connect(table)) as opened, opened:
        opened.execute("UPDATE messages SET timestamp = x'00ff' WHERE id = 2")
    with pytest.raises(InputError, match="is no whole number"):
        read_recording(tmp_path / "bot")


def test_truncated_mcap_is_refused(tmp_path):
    file = next(write_bag(every_channel(), tmp_path / "drive").glob("*.mcap"))
    file.write_bytes(file.read_bytes()[:-3000])
    with pytest.raises(InputError, match="damaged or cut short"):
        read_recording(file)


def test_existing_bag_is_not_overwritten(tmp_path):
    write_bag(every_channel(), tmp_path / "drive.bag")
    with pytest.raises(InputError, match="exists already"):
        write_bag(every_channel(), tmp_path / "drive.bag")


def vector(store, *xyz):
    return store.types["geometry_msgs/msg/Vector3"](*xyz)


def tag_messages():
    """Return the same detection in the three messages of the same name."""
    now, old = typestore(), typestore(old_tags=True)
    turn = now.types["geometry_msgs/msg/Quaternion"](0.0, 0.6, 0.0, 0.8)
    pose = now.types["geometry_msgs/msg/Pose"](now.types["geometry_msgs/msg/Point"](0.1, 0.2, 0.3), turn)
    header = message(now, "duckietown_msgs/msg/BoolStamped", 0.0, data=True).header
    current = now.types["duckietown_msgs/msg/AprilTagDetection"](
        now.types["geometry_msgs/msg/Transform"](vector(now, 0.1, 0.2, 0.3), turn), 301, "tag36h11", 0, 50.0,
        np.zeros(9, np.float32), np.zeros(2, np.float32), np.zeros(8, np.float32), 0.0,
    )  # fmt: skip
    stamped = old.types["geometry_msgs/msg/PoseStamped"](header, pose)
    elder = old.types["duckietown_msgs/msg/AprilTagDetection"](301, 0.065, stamped)
    covered = now.types["geometry_msgs/msg/PoseWithCovariance"](pose, np.zeros(36))
    other = now.types["apriltags2_ros/msg/AprilTagDetection"](
        np.array([301], np.int32),
        np.array([0.065]),
        now.types["geometry_msgs/msg/PoseWithCovarianceStamped"](header, covered),
    )  # fmt: skip
    return [
        (now, now.types["duckietown_msgs/msg/AprilTagDetectionArray"](header, [current])),
        (old, old.types["duckietown_msgs/msg/AprilTagDetectionArray"]([elder])),
        (now, now.types["apriltags2_ros/msg/AprilTagDetectionArray"](header, [other])),
    ]


@pytest.mark.parametrize("which", [0, 1, 2])
def test_each_of_the_three_tag_messages_is_understood(which):
    store, built = tag_messages()[which]
    raw = store.serialize_cdr(built, built.__msgtype__)
    (row,) = rows_of_message(1.5, store.deserialize_cdr(raw, built.__msgtype__))
    assert (row.time, row.tag_id) == (1.5, 301)
    assert row.translation == pytest.approx((0.1, 0.2, 0.3))
    assert row.quaternion == pytest.approx((0.0, 0.6, 0.0, 0.8))
