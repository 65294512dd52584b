"""Commands that have nothing to do with the poses are refused; those of real robots are not."""

import dataclasses

import numpy as np
import pytest
from recording_samples import SHARED
from typer.testing import CliRunner

from fsm_calib.cli import app
from fsm_calib.diagnosis.identify.explained import explained_shares, refuse_slow, refuse_unexplained
from fsm_calib.diagnosis.identify.identify import identify
from fsm_calib.errors import DataError
from fsm_calib.recording import CommandTrack, PoseTrack, Recording, RobotFacts, TwistTrack, read_recording
from fsm_calib.recording.writers import write_recording


def drive(seed: int, seconds: float = 60.0) -> Recording:
    """Return a robot that follows commands held for a second each, with 0.2 s time constants."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, seconds, 0.05)
    left, right = (np.repeat(rng.uniform(-0.2, 0.6, int(seconds) + 1), 20)[: len(time)] for _ in range(2))
    v, w = 0.0, 0.0
    state, rows = np.zeros(3), []
    for a, b in zip(left, right, strict=True):
        rows.append(state.copy())
        v += 0.25 * (0.3 * (a + b) - v)
        w += 0.25 * (6.0 * (b - a) - w)
        state += 0.05 * np.array([v * np.cos(state[2]), v * np.sin(state[2]), w])
    x, y, theta = (np.array(rows) + rng.normal(0.0, 0.002, (len(rows), 3))).T
    return Recording(
        RobotFacts("robot", 0.0318, 0.1, 20.0),
        command=CommandTrack(time, left, right),
        pose=PoseTrack(time, x, y, theta),
    )


def with_commands_of(recording: Recording, other: Recording) -> Recording:
    return dataclasses.replace(recording, command=other.command)


@pytest.mark.parametrize("seed", range(6))
def test_commands_of_another_drive_are_refused(seed: int) -> None:
    with pytest.raises(DataError, match="the commands do not explain the motion"):
        identify([with_commands_of(drive(seed), drive(100 + seed))])


def test_refusal_ends_with_exit_code_1_and_a_cure(tmp_path) -> None:
    manifest = write_recording(with_commands_of(drive(1), drive(2)), tmp_path / "r")
    result = CliRunner().invoke(app, ["identify", str(manifest), "--json", str(tmp_path / "out.json")])
    assert result.exit_code == 1
    assert "of the same drive" in result.output
    assert not (tmp_path / "out.json").exists()


@pytest.mark.parametrize("seed", range(6))
def test_commands_that_moved_the_robot_explain_it_whatever_their_signs(seed: int) -> None:
    recording = drive(seed)
    turned = dataclasses.replace(
        recording,
        command=CommandTrack(recording.command.time, -recording.command.right, recording.command.left),
    )
    for commands in (recording, turned):
        assert min(explained_shares(commands).values()) > 0.8
        refuse_unexplained(commands)


def test_twist_commands_are_judged_alike() -> None:
    recording = drive(3)
    v = 0.3 * (recording.command.left + recording.command.right)
    omega = 6.0 * (recording.command.right - recording.command.left)
    own = dataclasses.replace(recording, command=None, twist=TwistTrack(recording.command.time, v, omega))
    refuse_unexplained(own)
    with pytest.raises(DataError):
        refuse_unexplained(dataclasses.replace(own, pose=drive(4).pose))


def test_steady_drive_leaves_nothing_to_explain() -> None:
    time = np.arange(0.0, 40.0, 0.05)
    noise = np.random.default_rng(0).normal(0.0, 0.002, (3, len(time)))
    pose = PoseTrack(time, 0.2 * time + noise[0], noise[1], noise[2])
    recording = Recording(command=CommandTrack(time, np.full(800, 0.3), np.full(800, 0.3)), pose=pose)
    assert explained_shares(recording) == {}
    refuse_unexplained(recording)


def test_short_recording_is_not_judged() -> None:
    assert explained_shares(drive(0, 12.0)) == {}


def test_fit_with_time_constants_that_no_robot_has_is_refused() -> None:
    refuse_slow(drive(0), 14.0, 0.3)
    with pytest.raises(DataError, match="do not explain the motion"):
        refuse_slow(drive(0), 14.0, 21.0)


def test_no_real_robot_is_refused() -> None:
    files = sorted(SHARED.glob("**/*recording.yaml"))
    if not files:
        pytest.skip("needs recordings of real robots below FSM_CALIB_SHARED/recordings")
    judged = 0
    for file in files:
        recording = read_recording(file)
        refuse_unexplained(recording)
        judged += bool(explained_shares(recording))
    assert judged >= 20
