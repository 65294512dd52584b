"""`recording init` writes a manifest that reads; `validate` and `schema` know manifests."""

import json

import numpy as np
import pytest
from test_recording_ros import small, two_poses
from typer.testing import CliRunner
from wild_bags import turtlebot

from fsm_calib.cli import app
from fsm_calib.recording import read_recording
from fsm_calib.recording.column_guesses import guessed

MOCAP = "timestamp,x [mm],y [mm],yaw_deg\n" + "".join(
    f"2024-05-01T10:00:{t:06.3f}Z,{1e3 * np.sin(t / 3):.1f},{1e3 - 1e3 * np.cos(t / 3):.1f},{np.degrees(t / 3):.2f}\n"
    for t in np.arange(0.0, 20.0, 0.1)
)
QUATERNION = ["qx", "qy", "qz", "qw"]
WHEELS = "time,left_rpm,right_rpm\n" + "".join(f"{1714557600 + 0.5 * k:.1f},60,70\n" for k in range(40))


def run(*arguments):
    return CliRunner().invoke(app, list(map(str, arguments)))


def test_tables_with_units_in_their_headers_become_a_manifest_that_reads(tmp_path):
    (tmp_path / "mocap.csv").write_text(MOCAP)
    (tmp_path / "wheels.csv").write_text(WHEELS)
    ran = run("recording", "init", tmp_path / "mocap.csv", tmp_path / "wheels.csv")
    assert ran.exit_code == 0, ran.stderr
    found = read_recording(tmp_path / "mocap")
    assert np.abs(found.pose.x).max() == pytest.approx(1.0, abs=0.01)
    assert found.pose.theta[-1] == pytest.approx(19.9 / 3, abs=1e-3)
    assert found.wheel_rate.left[0] == pytest.approx(2.0 * np.pi)
    assert found.wheel_rate.time[1] == 0.5


def test_a_bag_becomes_a_manifest_that_names_its_topics(tmp_path):
    path = turtlebot(small(), "mcap").write(tmp_path / "drive")
    ran = run("recording", "init", path)
    assert (
        'pose: {topic: "/vrpn/tb3/pose"}   # /vrpn/tb3/pose (PoseStamped, 120 messages, 20 Hz)' in ran.stdout
    )
    assert "# not read: /goal_pose" in ran.stdout
    assert read_recording(tmp_path / "drive.recording.yaml") == read_recording(path)


def test_a_bag_with_two_poses_says_so_in_the_draft(tmp_path):
    ran = run("recording", "init", two_poses(tmp_path))
    assert "# 2 topics could be the pose; these would serve: /a/pose" in ran.stdout
    assert "# not read: /b/pose" in ran.stdout


def test_an_existing_manifest_is_not_overwritten(tmp_path):
    (tmp_path / "w.csv").write_text(WHEELS)
    (tmp_path / "w.recording.yaml").write_text("mine")
    ran = run("recording", "init", tmp_path / "w.csv")
    assert ran.exit_code == 2
    assert (tmp_path / "w.recording.yaml").read_text() == "mine"


def test_a_table_of_unknown_columns_is_refused_with_the_cure(tmp_path):
    (tmp_path / "w.csv").write_text("a,b\n1,2\n")
    ran = run("recording", "init", tmp_path / "w.csv")
    assert ran.exit_code == 2
    assert "no column is a time by its name: a, b" in ran.stderr


@pytest.mark.parametrize(
    ("header", "channel", "section"),
    [
        (["t", "v", "omega"], "command", {"v": "v", "omega": "omega", "unit": "twist"}),
        (["stamp_ns", "left_ticks", "right_ticks"], "wheel_angle", {"unit": "tick", "time_unit": 1e-9}),
        (
            ["time", "pose.position.x", "pose.position.y", "qx", "qy", "qz", "qw"],
            "pose",
            {"quaternion": ["qx", "qy", "qz", "qw"]},
        ),
        (["t_ms", "gyro_z_degps"], "yaw_rate", {"unit": "deg/s", "time_unit": 1e-3}),
        (["t", "u_left", "u_right"], "command", {"left": "u_left", "unit": "normalized"}),
        (
            ["t [ms]", "PWM_L (%)", "PWM_R (%)"],
            "command",
            {"left": "PWM_L (%)", "full": 100, "time_unit": 1e-3},
        ),
        (["time", "cmdLeft", "cmdRight"], "command", {"right": "cmdRight", "unit": "normalized"}),
        (["t", "vl", "vr"], "wheel_speed", {"left": "vl", "unit": "m/s"}),
        (["t", "wl", "wr"], "wheel_rate", {"right": "wr"}),
        (
            ["tMs", "posX", "posY", "yawDeg"],
            "pose",
            {"theta": "yawDeg", "angle_unit": "deg", "time_unit": 1e-3},
        ),
        (["timestamp_ms", "rpm_left", "rpm_right"], "wheel_rate", {"left": "rpm_left", "unit": "rpm"}),
        (
            ["Time", "Linear velocity", "Angular velocity [deg/s]"],
            "command",
            {"v": "Linear velocity", "unit": "twist", "angle_unit": "deg"},
        ),
    ],
)
def test_columns_are_known_by_name_and_unit(header, channel, section):
    (guess,) = guessed("f.csv", header)
    assert guess.channel == channel
    assert {key: guess.section[key] for key in section} == section


def test_validate_takes_a_manifest(tmp_path):
    (tmp_path / "w.csv").write_text(WHEELS)
    run("recording", "init", tmp_path / "w.csv")
    assert (
        "valid (robot, 19.5 s: wheel_rate (40 rows))" in run("validate", tmp_path / "w.recording.yaml").stdout
    )


def test_validate_tells_every_mistake_of_a_manifest_with_its_place(tmp_path):
    (tmp_path / "r.yaml").write_text(
        "format: fsm-calib/recording@1\nbag: x\nrobbot: {}\nchannels: {posse: {topic: a}}\n"
    )
    ran = run("validate", tmp_path / "r.yaml")
    assert ran.exit_code == 2
    assert "r.yaml:3:1: unknown key 'robbot'" in ran.stderr
    assert "r.yaml:4:12: unknown key 'channels.posse'" in ran.stderr


def test_the_schema_of_manifests_is_printed():
    plain = json.loads(run("schema", "--recording").stdout)
    assert {"Manifest", "BagManifest"} <= plain["$defs"].keys()


def test_a_table_of_unknown_columns_beside_a_known_one_is_said_to_be_unknown(tmp_path):
    (tmp_path / "mocap.csv").write_text(MOCAP)
    (tmp_path / "log.csv").write_text("when,what\n1,2\n")
    assert run("recording", "init", tmp_path / "mocap.csv", tmp_path / "log.csv").exit_code == 0
    assert '# command: {file: "log.csv"' in (tmp_path / "mocap.recording.yaml").read_text()


def test_a_bare_table_is_told_how_it_becomes_a_recording(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(WHEELS)
    for command in ("identify", "diagnose", "validate"):
        ran = run(command, path)
        assert ran.exit_code == 2
        assert "fsm-calib recording init" in ran.stderr


def test_columns_that_no_channel_reads_are_listed_and_what_is_missing_can_be_filled_in(tmp_path):
    (tmp_path / "log.csv").write_text("time,x,y,battery\n0,0,0,12\n1,1,0,12\n")
    text = run("recording", "init", tmp_path / "log.csv").stdout
    assert "# not read: battery" in text
    assert '# command: {file: "log.csv", time: COLUMN, left: COLUMN, right: COLUMN, unit: normalized}' in text
    assert "# no poses" not in text


def test_a_table_without_poses_says_how_they_are_named(tmp_path):
    (tmp_path / "w.csv").write_text(WHEELS)
    assert '# pose: {file: "w.csv", time: COLUMN' in run("recording", "init", tmp_path / "w.csv").stdout


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("0.0,1,2\n0.1,2,3\n", "w.csv:1: the first line holds numbers"),
        ("time,x,y\n", "w.csv:1: the file has a header but no rows"),
        ("time,this,that\n1,2,3\n", "beside the time no column is known by its name: time, this, that"),
    ],
    ids=["no header", "no rows", "unknown"],
)
def test_a_table_that_makes_no_draft_is_refused_with_what_it_lacks(tmp_path, text, said):
    (tmp_path / "w.csv").write_text(text)
    ran = run("recording", "init", tmp_path / "w.csv")
    assert (ran.exit_code, said in ran.stderr) == (2, True)
    assert not (tmp_path / "w.recording.yaml").exists()


def test_a_folder_that_is_no_bag_is_refused_as_one(tmp_path):
    assert "without metadata.yaml is no ROS 2 bag" in run("recording", "init", tmp_path).stderr


def test_a_folder_of_recordings_is_told_what_it_holds(tmp_path):
    for name in ("v", "w"):
        (tmp_path / f"{name}.recording.yaml").write_text("")
    assert "It holds v.recording.yaml, w.recording.yaml: name those." in run("identify", tmp_path).stderr
