"""The next drive as files: commands that can be played, a page, and what `diagnose --plan` says."""

import csv
import dataclasses
import json

import numpy as np
import pytest
from diagnosis_robots import recording
from rosbags.highlevel import AnyReader
from typer.testing import CliRunner

from fsm_calib.cli import app
from fsm_calib.commands.next_drive import area_of
from fsm_calib.diagnosis.design.area import Area
from fsm_calib.diagnosis.design.plan import Forecast, Outlook, Plan, Waypoint
from fsm_calib.errors import InputError
from fsm_calib.recording.channels import TwistTrack
from fsm_calib.recording.playable import Commands, write_playable
from fsm_calib.recording.recording import Recording, RobotFacts
from fsm_calib.recording.writers import write_recording
from fsm_calib.report.next_drive import commands_of, next_drive_page
from fsm_calib.types import Pose2

PLAN = Plan(
    holds=((1.0, 0.3, 0.2), (0.5, 0.0, 0.0)),
    manoeuvres=(Waypoint(0.0, "arc right at 0.3", 1.5),),
    start=Pose2(),
    forecast=Forecast(0.55, 0.97, 0.6, 0.7),
    outlooks=(
        Outlook(("tyre_scrub",), 0.55, 0.98, Pose2(0.2, 0.0, 0.0), ""),
        Outlook((), 0.45, 0.96, Pose2(0.3, -0.1, -1.0), "tyre_scrub"),
    ),
    path=np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.2, 0.0, 0.0]]),
)
COMMANDS = Commands(np.array([0.0, 0.22, 0.5]), np.array([[0.3, 0.2], [-0.1, 0.1], [0.0, 0.0]]))


def test_csv_holds_each_command_until_the_next(tmp_path):
    table, *_ = write_playable(COMMANDS, tmp_path)
    rows = list(csv.DictReader(table.open()))
    assert [float(row["left"]) for row in rows] == [0.3, -0.1, 0.0]
    assert [float(row["time"]) for row in rows] == [0.0, 0.22, 0.5]


@pytest.mark.parametrize("name", ["drive.bag", "drive_ros2"])
def test_bag_repeats_commands_on_the_topic_that_the_driver_hears(tmp_path, name):
    write_playable(COMMANDS, tmp_path, "/duckie")
    with AnyReader([tmp_path / name]) as reader:
        said = [(stamp, reader.deserialize(raw, c.msgtype), c.topic) for c, stamp, raw in reader.messages()]
    stamps = np.array([stamp for stamp, *_ in said]) * 1e-9
    assert {topic for *_, topic in said} == {"/duckie/wheels_driver_node/wheels_cmd"}
    assert np.diff(stamps).max() < 0.06
    left = np.array([message.vel_left for _, message, _ in said])
    assert left[np.searchsorted(stamps - stamps[0], 0.2)] == pytest.approx(0.3)
    assert left[np.searchsorted(stamps - stamps[0], 0.23)] == pytest.approx(-0.1)
    assert left[-1] == 0.0


def test_page_says_how_far_none_of_its_explanations_is_believed():
    doubted = dataclasses.replace(PLAN, forecast=dataclasses.replace(PLAN.forecast, sureness_before=0.22))
    said = " ".join(next_drive_page(doubted, Area(), "duckie").split())
    assert "that none of them is right is believed with 60 % now" in said


def test_page_says_nothing_of_it_where_one_of_them_is_right():
    assert "none of them" not in next_drive_page(PLAN, Area(), "duckie")


def test_bag_of_an_earlier_plan_is_replaced(tmp_path):
    write_playable(COMMANDS, tmp_path)
    assert len(write_playable(COMMANDS, tmp_path)) == 3


def test_robot_that_takes_twists_gets_twists():
    time = np.array([0.0])
    twist = Recording(robot=RobotFacts(axle_length=0.2), twist=TwistTrack(time, time, time))
    commands = commands_of(PLAN, twist, full_speed=0.5)
    assert commands.unit == "twist"
    assert commands.values[0] == pytest.approx([0.125, -0.25])


def test_page_tells_promise_outcomes_and_size():
    page = next_drive_page(PLAN, Area(), "duckie")
    assert "55 % sure" in page
    assert "97 % sure" in page
    assert "tyre scrub" in page
    assert "2 x 2 m, 2 s" in page


@pytest.mark.parametrize("text", ["2", "2x", "axb", "0.1x2", "2x900"])
def test_floor_that_no_robot_can_use_is_refused(text):
    with pytest.raises(InputError, match="free floor"):
        area_of(text)


def test_diagnose_writes_the_next_drive(tmp_path):
    manifest = write_recording(recording(0, 12.0), tmp_path / "drive")
    plan = tmp_path / "next"
    answer = CliRunner().invoke(app, ["diagnose", str(manifest), "--plan", str(plan), "--area", "1.6x1.6"])
    assert answer.exit_code == 0, answer.output
    assert "next drive: 1.6 x 1.6 m" in answer.output
    said = json.loads((plan / "plan.json").read_text())
    assert said["expected"] > said["before"]
    assert (plan / "index.html").exists()
