"""Commands that were lost on the way into a log: counted, told, and what the robot did meanwhile is left out."""

import dataclasses

import numpy as np
import pytest
from diagnosis_robots import decided, recording
from wild_bags import BagWriter

from fsm_calib.diagnosis.identify.identify import identify
from fsm_calib.diagnosis.replay.prepared import prepare
from fsm_calib.recording import CommandTrack, PoseTrack, Recording, read_recording
from fsm_calib.recording.unknown_commands import lost_before, unknown_spans
from fsm_calib.recording.writers import write_bag, write_recording

TIME = np.arange(0.0, 20.0, 0.05)
GAIN, AXLE = 0.6, 0.1  # m/s at command 1, m


def commands(lost=None, stale_after=None) -> CommandTrack:
    return CommandTrack(
        np.array([0.0, 1.0, 2.0, 5.0]), np.ones(4), np.ones(4), stale_after=stale_after, lost=lost
    )


def test_messages_that_follow_each_other_lost_nothing():
    assert lost_before([7, 8, 9]) == pytest.approx([0.0, 0.0, 0.0])


def test_a_leap_of_the_numbers_counts_what_is_missing():
    assert lost_before([7, 8, 9, 13, 14]) == pytest.approx([0.0, 0.0, 0.0, 3.0, 0.0])


def test_every_third_message_is_a_count_too():
    assert lost_before([3, 6, 9, 18, 21]) == pytest.approx([0.0, 0.0, 0.0, 2.0, 0.0])


@pytest.mark.parametrize(
    "numbers",
    [[0, 0, 0], [5], [], [1, 40, 2, 41, 3], [1, 5, 6, 17, 40, 90]],
    ids=["none", "one", "no message", "two publishers", "leaps"],
)
def test_numbers_that_are_no_count_tell_nothing(numbers):
    assert lost_before(numbers) is None


def test_all_commands_are_known_where_none_was_lost_or_is_old():
    assert len(unknown_spans(commands(np.zeros(4)))) == 0
    assert len(unknown_spans(commands())) == 0


def test_from_the_last_command_before_a_loss_to_the_first_after_nobody_knows():
    assert unknown_spans(commands(np.array([0.0, 0.0, 2.0, 0.0]))) == pytest.approx(np.array([[1.0, 2.0]]))


def test_an_old_command_is_known_until_it_is_old():
    found = unknown_spans(commands(stale_after=1.5))
    assert found == pytest.approx(np.array([[3.5, 5.0], [6.5, np.inf]]))


def test_a_loss_counts_from_the_last_row_even_where_commands_grow_old():
    found = unknown_spans(commands(np.array([0.0, 0.0, 0.0, 1.0]), stale_after=1.5))
    assert found == pytest.approx(np.array([[2.0, 5.0], [6.5, np.inf]]))


def test_a_log_of_many_commands_ends_when_its_longest_pause_is_over():
    time = np.delete(np.arange(0.0, 12.0, 0.1), 50)
    found = unknown_spans(CommandTrack(time, time, time))
    assert found == pytest.approx(np.array([[time[-1] + 0.2, np.inf]]))


def turned(seconds: tuple[float, float]) -> Recording:
    """Return a drive whose robot turns for a while, by commands at 10 Hz, with poses by its exact motion."""
    time = np.arange(0.0, 20.0, 0.1)
    turns = (time >= seconds[0] - 1e-9) & (time < seconds[1] - 1e-9)
    wiggle = 0.05 * np.sign(np.sin(0.9 * time))
    left = 0.4 + wiggle + 0.1 * np.sign(np.sin(0.5 * time))
    right = left - 2.0 * wiggle + np.where(turns, 0.3, 0.0)
    theta, x, y = 0.0, 0.0, 0.0
    rows = []
    for now in TIME:
        rows.append((x, y, theta))
        k = int(now / 0.1 + 1e-6)
        v, w = GAIN * (left[k] + right[k]) / 2.0, GAIN * (right[k] - left[k]) / AXLE
        x, y = x + 0.05 * v * np.cos(theta + 0.025 * w), y + 0.05 * v * np.sin(theta + 0.025 * w)
        theta += 0.05 * w
    noise = np.random.default_rng(4).normal(0.0, [0.002, 0.002, 0.01], (len(TIME), 3))
    return Recording(
        command=CommandTrack(time, left, right), pose=PoseTrack(TIME, *(np.array(rows) + noise).T)
    )


def without_the_turn() -> Recording:
    """Return the drive as a recorder that lost the commands of its turn, from 9.9 to 12.1 s."""
    drive = turned((10.0, 12.0))
    keep = (drive.command.time < 9.95) | (drive.command.time > 12.15)
    lost = lost_before(np.flatnonzero(keep))
    return dataclasses.replace(drive, command=dataclasses.replace(drive.command.rows(keep), lost=lost))


def test_motion_by_lost_commands_is_not_scored():
    prepared = prepare(without_the_turn())
    scored = prepared.scored[:, 0]
    meanwhile = (prepared.time > 9.96) & (prepared.time < 12.2)
    assert not scored[meanwhile].any()
    assert scored[(prepared.time > 1.0) & (prepared.time < 9.9)].all()
    assert scored[prepared.time > 14.0].all()


def begun(motion: float, commands: float) -> Recording:
    """Return a drive that was logged from 5 s on, at rest until `motion`, its commands from `commands` [s] on."""
    drive = turned((12.0, 14.0))
    keep, told = drive.pose.time >= 5.0, drive.command.time >= commands - 1e-9
    x, y, theta = (
        np.where(drive.pose.time < motion, np.interp(motion, drive.pose.time, column), column)
        for column in (drive.pose.x, drive.pose.y, drive.pose.theta)
    )
    poses = PoseTrack(TIME[keep], x[keep], y[keep], theta[keep])
    return dataclasses.replace(drive, command=drive.command.rows(told), pose=poses)


def test_a_robot_that_moves_before_its_first_command_is_not_scored_until_the_command_has_settled():
    prepared = prepare(begun(motion=0.0, commands=7.0))
    assert not prepared.scored[prepared.time <= 7.5].any()
    assert prepared.scored[prepared.time > 7.56, 0].all()


def test_a_robot_that_moves_when_its_log_begins_is_scored_when_the_command_has_settled():
    prepared = prepare(begun(motion=0.0, commands=5.0))
    assert not prepared.scored[prepared.time <= 5.5].any()
    assert prepared.scored[prepared.time > 5.56, 0].all()


def test_a_robot_at_rest_before_its_first_command_is_scored_from_the_start():
    prepared = prepare(begun(motion=7.0, commands=7.0))
    assert prepared.scored[1:, 0].all()


def test_identify_is_not_misled_by_a_lost_turn():
    known = without_the_turn()
    believed = dataclasses.replace(known, command=dataclasses.replace(known.command, lost=None))
    right, wrong = (identify([r]).value("wheel_gain_left") for r in (known, believed))
    assert right == pytest.approx(GAIN, rel=0.02)
    assert abs(wrong - GAIN) > 5.0 * abs(right - GAIN)


def test_a_loss_is_told_with_its_seconds(tmp_path):
    bag = BagWriter("ros1")
    for number, time in enumerate(np.arange(0.0, 6.0, 0.05)):
        bag.add(time, "/vrpn/a/pose", "geometry_msgs/msg/PoseStamped", pose=bag.pose(0.1 * time, 0.0, 0.0))
        if not 40 <= number < 60:
            bag.add(time, "/cmd_vel", "geometry_msgs/msg/TwistStamped", seq=number, twist=bag.twist(0.1, 0.0))
    found = read_recording(bag.write(tmp_path / "lossy"))
    told = next(str(finding) for finding in found.checks if finding.kind == "lost")
    assert "command: 20 commands never reached the log" in told
    assert "leap once after 1.95 s" in told
    assert "1.1 s is left out" in told


@pytest.mark.parametrize("form", ["bag", "csv"])
def test_losses_are_kept_by_every_writer(tmp_path, form):
    drive = without_the_turn()
    if form == "bag":
        found = read_recording(write_bag(drive, tmp_path / "kept.bag"))
    else:
        found = read_recording(write_recording(drive, tmp_path / "kept"))
    assert found.command == drive.command


def test_a_clean_robot_whose_log_begins_in_mid_drive_is_not_said_to_be_pushed():
    drive = recording(4)
    keep, told = drive.pose.time > 9.0, drive.command.time > 9.0
    begun = dataclasses.replace(drive, pose=drive.pose.rows(keep), command=drive.command.rows(told))
    assert drive.command.time[told][0] > 9.3  # what it is doing meanwhile nobody knows
    decision = decided([begun], ("external_push", "motor_fault", "payload_offset"))
    assert decision.outcome == "match"
