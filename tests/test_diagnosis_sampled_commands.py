"""Commands that a logger sampled are laid where the robot followed them; others stay where they are."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_robots import START, drive, recording, robot

from fsm_calib.diagnosis.intake import take_in
from fsm_calib.diagnosis.sampled_commands import row_step, with_changes_placed
from fsm_calib.recording.channels import CommandTrack
from fsm_calib.world2d.observation import predict
from fsm_calib.world2d.rollout import Drive

STEP = 0.06  # s


def sampled(track, step=STEP):
    """Return commands as a logger sees them that looks every `step` [s]."""
    time = np.arange(track.time[0] + 0.4 * step, track.time[-1] + 2.0, step)
    row = np.searchsorted(track.time, time, side="right") - 1
    return CommandTrack(time, track.left[row], track.right[row])


def logged(seed=0):
    seen = recording(seed)
    return replace(seen, command=sampled(seen.command))


def written_by_its_own_loop():
    """Return a recording of a robot that is told something new only when its log gets a row."""
    told = drive(np.random.default_rng(0), 40.0)
    on_rows = Drive(np.ceil(told.time / STEP - 1e-6) * STEP, told.left, told.right)
    seen = recording(0)
    poses = predict(robot(), on_rows, seen.pose.time, START).poses
    noise = np.random.default_rng(5).normal(size=poses.shape) * [0.002, 0.002, 0.006]
    time = np.arange(round(on_rows.time[0] / STEP), round(on_rows.time[-1] / STEP) + 20) * STEP
    row = np.searchsorted(on_rows.time, time + 1e-6, side="right") - 1
    command = CommandTrack(time, on_rows.left[row], on_rows.right[row])
    pose = replace(seen.pose, x=(poses + noise)[:, 0], y=(poses + noise)[:, 1], theta=(poses + noise)[:, 2])
    return replace(seen, command=command, pose=pose)


def test_a_log_of_regular_rows_that_mostly_repeat_was_sampled():
    assert row_step(logged().command) == pytest.approx(STEP)


def test_commands_as_they_were_sent_were_not_sampled():
    assert row_step(recording(0).command) is None


def test_a_controller_that_sends_something_new_in_each_row_is_not_sampled():
    time = np.arange(0.0, 10.0, STEP)
    assert row_step(CommandTrack(time, np.sin(time), np.cos(time))) is None


def test_sampled_commands_are_laid_half_a_row_earlier_and_told():
    before = logged()
    (after,), (said,) = with_changes_placed([before])
    moved = before.command.time[0] - after.command.time[0]
    assert moved == pytest.approx(0.5 * STEP, abs=0.01)
    assert "sampled every 60 ms" in said


def test_a_log_that_the_robots_own_loop_wrote_stays():
    before = written_by_its_own_loop()
    assert row_step(before.command) == pytest.approx(STEP)
    assert with_changes_placed([before]) == ([before], [])


def test_what_is_taken_in_says_so():
    assert any("sampled every" in note for note in take_in([logged()]).notes)
