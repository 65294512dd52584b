"""The forms that other people's robots leave are read with one option at most, and as what they are."""

import dataclasses
import json

import numpy as np
import pytest
from typer.testing import CliRunner
from wild_forms import SINGLE, Robot, driven, wheel_truth

from fsm_calib.cli import app
from fsm_calib.diagnosis.fine_clocks import with_fine_clocks
from fsm_calib.diagnosis.identify.identify import identify
from fsm_calib.errors import InputError
from fsm_calib.recording import read_recording
from fsm_calib.recording.draft import draft_of_tables
from fsm_calib.recording.named import Named
from fsm_calib.recording.robot_files import read_robot_file

TABLES = {
    "decimal commas": (
        ";",
        lambda v: f"{v:.6f}".replace(".", ","),
        ("Time [s]", "X [m]", "Y [m]", "Yaw [rad]"),
    ),
    "printed by rostopic": (",", lambda v: f"{v:.6f}", ("%time", "field.x", "field.y", "field.theta")),
}


@pytest.mark.parametrize("form", TABLES)
def test_tables_of_other_houses_are_drafted_and_read(tmp_path, form):
    mark, written, names = TABLES[form]
    pose = driven(seed=3, duration=10.0).pose
    rows = zip(pose.time, pose.x, pose.y, pose.theta, strict=True)
    lines = [mark.join(names), *(mark.join(map(written, row)) for row in rows)]
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
    (tmp_path / "log.recording.yaml").write_text(draft_of_tables([tmp_path / "log.csv"], tmp_path))
    found = read_recording(tmp_path / "log.recording.yaml").pose
    assert found.x == pytest.approx(pose.x, abs=1e-6)
    assert found.theta == pytest.approx(pose.theta, abs=1e-6)


def two_robots_in_one_file(folder, name):
    rows = [
        f"{0.1 * i:.1f},{bot},{x + 0.01 * i:.2f},0.0"
        for i in range(40)
        for bot, x in (("a", 0.0), ("b", 2.0))
    ]
    (folder / "p.csv").write_text("t,robot,x,y\n" + "\n".join(rows) + "\n")
    (folder / "recording.yaml").write_text(
        "format: fsm-calib/recording@1\nchannels:\n"
        f"  pose: {{file: p.csv, time: t, x: x, y: y, only: {{robot: {name}}}}}\n"
    )
    return folder


def test_one_of_two_robots_in_a_file_is_taken_by_its_name(tmp_path):
    assert read_recording(two_robots_in_one_file(tmp_path, "b")).pose.x[0] == 2.0


def test_a_robot_that_is_not_in_the_file_is_refused_with_those_that_are(tmp_path):
    with pytest.raises(InputError, match=r"'c'.*Known: a, b"):
        read_recording(two_robots_in_one_file(tmp_path, "c"))


@pytest.mark.parametrize("nothing", ["", "nan"])
def test_rows_of_a_tracker_that_lost_the_robot_are_left_out_and_told(tmp_path, nothing):
    lines = [f"{0.1 * i:.1f},{0.01 * i:.2f},0.0,0.0" for i in range(40)]
    lines[7] = f"0.7,{nothing},{nothing},{nothing}"
    (tmp_path / "p.csv").write_text("t,x,y,theta\n" + "\n".join(lines) + "\n")
    (tmp_path / "recording.yaml").write_text(
        "format: fsm-calib/recording@1\nchannels:\n  pose: {file: p.csv, time: t, x: x, y: y, theta: theta}\n"
    )
    found = read_recording(tmp_path)
    assert len(found.pose) == 39
    assert any("1 rows are empty or NaN" in finding.sentence for finding in found.checks)


def read(form):
    """Read a form as the commands do."""
    path, *option = form.arguments
    given = dict(zip(option[::2], option[1::2], strict=True))
    robot = read_robot_file(given["--urdf"]) if "--urdf" in given else None
    return read_recording(path, given.get("--tag-map"), Named(pose=given.get("--pose"), robot=robot))


@pytest.fixture(scope="module")
def forms(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wild")
    made = {}
    for name in ("epoch_table", "rpm_and_degrees", "millimetres", "upright_tags", "two_clocks", "described"):
        (folder / name).mkdir()
        made[name] = SINGLE[name](folder / name)
    return made


@pytest.mark.parametrize(
    ("name", "seed"), [("epoch_table", 3), ("rpm_and_degrees", 4), ("millimetres", 5), ("two_clocks", 9)]
)
def test_poses_of_a_table_are_those_of_the_drive(forms, name, seed):
    found, true = read(forms[name]).pose, driven(seed=seed).pose
    assert found.time == pytest.approx(true.time, abs=1e-5)
    assert found.x == pytest.approx(true.x, abs=1e-6)
    assert np.exp(1j * found.theta) == pytest.approx(np.exp(1j * true.theta), abs=1e-6)


def test_rates_in_rpm_are_read_as_such(forms):
    rates = read(forms["rpm_and_degrees"]).wheel_rate
    true = driven(seed=4).wheel_angle
    assert rates.left == pytest.approx(np.gradient(true.left, true.time), rel=1e-6, abs=1e-6)


def test_commands_of_another_computer_are_brought_to_the_poses(forms):
    found = read(forms["two_clocks"]).twist.time
    assert found == pytest.approx(driven(seed=9).twist.time, abs=0.06)


def test_a_diagnosis_lays_commands_of_another_computer_on_the_poses_to_milliseconds(forms):
    (found,), (said,) = with_fine_clocks([read(forms["two_clocks"])])
    assert found.twist.time == pytest.approx(driven(seed=9).twist.time, abs=0.003)
    assert "on another clock" in said


def test_a_clock_that_the_reader_laid_a_quarter_second_off_is_laid_right(forms):
    near = read(forms["two_clocks"])
    off = dataclasses.replace(near, twist=dataclasses.replace(near.twist, time=near.twist.time - 0.25))
    (found,), _ = with_fine_clocks([off])
    assert found.twist.time == pytest.approx(driven(seed=9).twist.time, abs=0.003)


def test_commands_on_the_clock_of_the_poses_stay_where_they_are(forms):
    recording = read(forms["epoch_table"])
    assert with_fine_clocks([recording]) == ([recording], [])


@pytest.mark.slow
def test_diagnose_takes_a_map_of_upright_tags(forms, tmp_path):
    out, form = tmp_path / "out.json", forms["upright_tags"]
    ran = CliRunner().invoke(app, ["diagnose", *map(str, form.arguments), "--json", str(out)])
    assert ran.exit_code == 0
    assert json.loads(out.read_text())["verdict"] == "match"


def test_upright_tags_tell_the_drive(forms):
    found, true = read(forms["upright_tags"]).pose, driven(seed=6, rate=8.0).pose
    assert found.x == pytest.approx(true.x, abs=0.02)
    assert found.theta == pytest.approx(np.arctan2(np.sin(true.theta), np.cos(true.theta)), abs=0.02)


def test_a_urdf_robot_is_identified_within_three_deviations(forms):
    recording = read(forms["described"])
    assert (recording.robot.wheel_radius, recording.robot.mass) == (0.05, 4.0)
    found = identify([recording.window(0.0, 12.0)])
    for name, true in wheel_truth(Robot(0.05, 0.24)).items():
        estimate = found.estimates[name]
        assert abs(estimate.value - true) < 3.0 * estimate.sd


@pytest.mark.parametrize("late", [-0.3, 0.021, 0.13])
def test_commands_that_act_late_or_on_another_clock_do_not_move_the_gains(late):
    drive = dataclasses.replace(driven(seed=30, duration=20.0), wheel_angle=None)
    twist = dataclasses.replace(drive.twist, time=drive.twist.time - late)
    found = identify([dataclasses.replace(drive, twist=twist)])
    for name in ("forward_gain", "turn_gain"):
        assert abs(found.estimates[name].value - 1.0) < 3.0 * found.estimates[name].sd
    assert found.value("command_delay") == pytest.approx(late, abs=0.005)
    assert any("beside the time constants" in note for note in found.notes)
