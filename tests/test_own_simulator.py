"""A simulator that can be called: driven by the recordings' commands, described, and mended by what it lacks."""

import json
import sys

import numpy as np
import pytest
from diagnosis_robots import recording, robot
from typer.testing import CliRunner

from fsm_calib.cli import app
from fsm_calib.commands.own_simulator import simulator_of
from fsm_calib.diagnosis.against import diagnose_against
from fsm_calib.diagnosis.around import around, increments_of, simulated_recordings
from fsm_calib.diagnosis.own_simulator import commands_of, path_of, poses_at
from fsm_calib.errors import DataError, InputError
from fsm_calib.recording.channels import TwistTrack
from fsm_calib.recording.recording import Recording
from fsm_calib.recording.writers import write_recording
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.observation import predict
from fsm_calib.world2d.rollout import Drive

CONSIDERED = ("motor_deadband", "motor_reverse_asymmetry")
WITHOUT = [name for name in registry() if name not in CONSIDERED]
HIDDEN = {"motor_deadband__offset": 0.08}
FILE = '''
import numpy as np

def drive(commands):
    """An ideal robot: 0.6 m/s at command 1, 0.1 m between its wheels."""
    time = np.arange(commands["time"][0], commands["time"][-1] + 0.02, 0.02)
    at = np.searchsorted(commands["time"], time, side="right") - 1
    left, right = (0.6 * commands[side][at] for side in ("left", "right"))
    theta = np.cumsum((right - left) / 0.1) * 0.02
    v = 0.5 * (left + right)
    return np.column_stack([time, np.cumsum(v * np.cos(theta)) * 0.02, np.cumsum(v * np.sin(theta)) * 0.02, theta])

def broken(commands):
    raise RuntimeError("out of batteries")
'''
PROGRAM = """
import sys
import numpy as np
sys.path.insert(0, {folder!r})
from mine import drive
table = np.genfromtxt(sys.argv[1], delimiter=",", names=True)
poses = drive({{name: table[name] for name in table.dtype.names}})
np.savetxt(sys.argv[2], poses, delimiter=",", header="time,x,y,theta", comments="")
"""


def plain(commands):
    """A simulator with the base robot's physics alone, every 20 ms."""
    stamps = np.arange(0.0, commands["time"][-1] + 0.02, 0.02)
    drive = Drive(commands["time"][:-1], commands["left"][:-1], commands["right"][:-1])
    return np.column_stack([stamps, predict(robot(), drive, stamps, (0.0, 0.0, 0.0)).poses])


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A folder with `mine.py` and a program that uses it."""
    folder = tmp_path_factory.mktemp("mine")
    (folder / "mine.py").write_text(FILE)
    (folder / "program.py").write_text(PROGRAM.format(folder=str(folder)))
    return folder


@pytest.fixture(scope="module")
def found():
    train, new = ([recording(seed, 30.0, **HIDDEN) for seed in seeds] for seeds in ((1, 2), (3,)))
    return diagnose_against(train, simulated_recordings(plain, train), new, without=WITHOUT)


def test_what_it_lacks_is_named(found):
    assert found.as_json()["against"]["lacks"] == ["motor_deadband"]
    assert found.simulated.verdict.verdict == "match"


def test_with_the_remainder_around_it_it_predicts_a_new_drive_to_the_noise(found):
    errors = around(found, plain)
    assert errors.on == "holdout"
    assert errors.before.theta_rad > 1.4 * errors.floor.theta_rad
    assert errors.after.theta_rad < 1.1 * errors.floor.theta_rad
    assert errors.after.xy_m < 1.1 * errors.floor.xy_m


def test_a_simulator_is_seen_by_the_real_robots_tracker():
    real = recording(1, 20.0)
    (seen,) = simulated_recordings(plain, [real])
    exact = poses_at(path_of(plain, real), real.pose.time)
    off = np.column_stack([seen.pose.x, seen.pose.y, seen.pose.theta]) - exact
    assert np.array_equal(seen.pose.time, real.pose.time)
    assert off[:, 0].std() == pytest.approx(0.002, rel=0.35)
    assert off[:, 2].std() == pytest.approx(0.006, rel=0.35)


def test_commands_end_with_the_recording_and_keep_its_unit():
    real = recording(1, 20.0)
    asked = commands_of(real)
    assert asked["time"][-1] == max(real.pose.time[-1], real.command.time[-1])
    twist = TwistTrack([0.0, 1.0], [0.1, 0.2], [0.0, 0.3])
    told = commands_of(Recording(real.robot, twist=twist, pose=real.pose))
    assert (list(told), list(told["v"])) == (["time", "v", "omega"], [0.1, 0.2, 0.2])
    with pytest.raises(DataError, match="nothing was recorded"):
        commands_of(Recording(real.robot, pose=real.pose))


def test_motion_between_poses_does_not_depend_on_where_they_begin():
    poses = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [1.5, 0.5, 1.0]])
    turned = poses @ np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]) + [3.0, 4.0, np.pi / 2]
    like = np.zeros((3, 5))
    assert increments_of(turned, like) == pytest.approx(increments_of(poses, like))
    assert increments_of(poses, like)[1] == pytest.approx([1.0, 0.0, 0.5, 0.0, 0.0])


def test_a_function_of_a_file_and_a_program_drive_alike(files):
    real = recording(1, 10.0)
    function = path_of(simulator_of(f"{files / 'mine.py'}:drive"), real)
    program = path_of(simulator_of(f"{sys.executable} {files / 'program.py'}"), real)
    assert program == pytest.approx(function, abs=1e-12)


@pytest.mark.parametrize(
    ("returned", "said"),
    [
        (lambda c: np.zeros((5, 3)), r"shape \(5, 3\)"),
        (lambda c: np.zeros((5, 4)), "do not increase"),
        (lambda c: np.column_stack([np.arange(9.0), *np.zeros((3, 9))]), "stops at 8.00 s"),
        (lambda c: [["a"] * 4] * 5, "does not return numbers"),
    ],
)
def test_what_is_no_path_is_refused_in_words(returned, said):
    with pytest.raises(DataError, match=said):
        path_of(returned, recording(1, 20.0))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("no_such_module:drive", "no module 'no_such_module'"),
        ("json:drive", "json has no function 'drive'"),
        ("no-such-program --fast", "no program 'no-such-program'"),
        ("nowhere.py:drive", "no such file"),
    ],
)
def test_a_simulator_that_is_not_there_is_told(text, said):
    with pytest.raises(InputError, match=said):
        simulator_of(text)


def test_a_simulator_that_fails_is_told_with_its_own_words(files):
    with pytest.raises(DataError, match="out of batteries"):
        simulator_of(f"{files / 'mine.py'}:broken")({})
    with pytest.raises(DataError, match="ended with 2"):
        simulator_of(f"{sys.executable} {files / 'nothing.py'}")(commands_of(recording(1, 10.0)))
    with pytest.raises(DataError, match="no table of poses"):
        simulator_of("true")(commands_of(recording(1, 10.0)))


def test_the_command_shows_the_simulators_error_before_and_after(files, tmp_path):
    real, new = (str(write_recording(recording(s, 30.0, **HIDDEN), tmp_path / str(s))) for s in (1, 2))
    hidden = [text for name in WITHOUT for text in ("--without", name)]
    out, mine = tmp_path / "verdict.json", f"{files / 'mine.py'}:drive"
    asked = ["diagnose", real, "--holdout", new, "--simulator", mine, "--json", str(out), *hidden]
    answer = CliRunner().invoke(app, asked)
    assert answer.exit_code == 0, answer.output
    assert "your simulator on holdout" in answer.output
    told = json.loads(out.read_text())["against"]["simulator"]
    assert told["after"]["xy_m"] < 0.5 * told["before"]["xy_m"]
