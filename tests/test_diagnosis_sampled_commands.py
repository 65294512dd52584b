"""Commands that a logger sampled are laid where the robot followed them; others stay where they are."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_robots import START, TICK, drive, recording, robot, with_encoders

from fsm_calib.diagnosis.intake import take_in
from fsm_calib.diagnosis.late_commands import fitted_delay
from fsm_calib.diagnosis.sampled_commands import SURELY_EARLY, row_step, with_changes_placed
from fsm_calib.recording.channels import CommandTrack, WheelPair
from fsm_calib.world2d.observation import predict
from fsm_calib.world2d.rollout import Drive

STEP = 0.06  # s
ROUGH = {
    f"rough_floor_patch__{name}": value for name, value in {"drag": 1.0, "half_x": 0.4, "half_y": 0.4}.items()
}


def sampled(track, step=STEP):
    """Return commands as a logger sees them that looks every `step` [s]."""
    time = np.arange(track.time[0] + 0.4 * step, track.time[-1] + 2.0, step)
    row = np.searchsorted(track.time, time, side="right") - 1
    return CommandTrack(time, track.left[row], track.right[row])


def logged(seed=0):
    seen = recording(seed)
    return replace(seen, command=sampled(seen.command))


def written_by_its_own_loop(**changes):
    """Return a recording of a `robot` with `changes` and encoders that is told something new only when its log gets
    a row.
    """
    told = drive(np.random.default_rng(0), 40.0)
    on_rows = Drive(np.ceil(told.time / STEP - 1e-6) * STEP, told.left, told.right)
    seen = recording(0, rate=50.0)
    wheels = np.arange(0.2, 29.0, 0.02)
    found = predict(robot(**changes), on_rows, seen.pose.time, START, wheel_times=wheels)
    poses, turned = found.poses, TICK * np.round(found.wheel_angles / TICK)
    noise = np.random.default_rng(5).normal(size=poses.shape) * [0.002, 0.002, 0.006]
    time = np.arange(round(on_rows.time[0] / STEP), round(on_rows.time[-1] / STEP) + 20) * STEP
    row = np.searchsorted(on_rows.time, time + 1e-6, side="right") - 1
    command = CommandTrack(time, on_rows.left[row], on_rows.right[row])
    pose = replace(seen.pose, x=(poses + noise)[:, 0], y=(poses + noise)[:, 1], theta=(poses + noise)[:, 2])
    return replace(
        seen, command=command, pose=pose, wheel_angle=WheelPair(wheels, *turned.T, resolution=TICK)
    )


def test_a_log_of_regular_rows_that_mostly_repeat_was_sampled():
    assert row_step(logged().command) == pytest.approx(STEP)


def test_commands_as_they_were_sent_were_not_sampled():
    assert row_step(recording(0).command) is None


def test_a_controller_that_sends_something_new_in_each_row_is_not_sampled():
    time = np.arange(0.0, 10.0, STEP)
    assert row_step(CommandTrack(time, np.sin(time), np.cos(time))) is None


def test_sampled_commands_are_laid_half_a_row_earlier_and_told():
    before = logged()
    (after,), _, (said,) = with_changes_placed([before])
    moved = before.command.time[0] - after.command.time[0]
    assert moved == pytest.approx(0.5 * STEP, abs=0.01)
    assert "sampled every 60 ms" in said


def test_a_log_that_the_robots_own_loop_wrote_stays():
    before = written_by_its_own_loop()
    assert row_step(before.command) == pytest.approx(STEP)
    assert with_changes_placed([before]) == ([before], [], [])


def test_what_is_taken_in_says_so():
    assert any("sampled every" in note for note in take_in([logged()]).notes)


def test_a_robot_on_a_floor_that_nobody_knows_does_not_answer_early():
    """Its delay is fitted as negative, for what its poses do before a row there is no earlier command."""
    before = written_by_its_own_loop(**ROUGH)
    delay, sd = fitted_delay(before)
    assert delay < -SURELY_EARLY * sd
    assert with_changes_placed([before]) == ([before], [], [])


def test_a_logger_is_known_by_what_the_robot_does_before_its_rows():
    seen = with_encoders(1, **ROUGH)
    before = replace(seen, command=sampled(seen.command))
    (after,), _, _ = with_changes_placed([before])
    assert before.command.time[0] - after.command.time[0] > 0.3 * STEP


def test_the_drive_that_is_held_out_decides_nothing():
    own, log = written_by_its_own_loop(), logged()
    assert with_changes_placed([own], [log]) == ([own], [log], [])
