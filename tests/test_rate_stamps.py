"""What a wheel rate's stamp stands for: declared, or told by the poses; a false delay is no longer named."""

import dataclasses

import numpy as np
import pytest
from wild_forms import Robot, driven

from fsm_calib.diagnosis.between_samples import with_bends
from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.diagnosis.rate_stamps import with_stamps
from fsm_calib.diagnosis.replay.wheels import wheels_of
from fsm_calib.errors import FsmCalibError
from fsm_calib.recording import Recording, WheelPair, read_recording
from fsm_calib.recording.recording import RobotFacts
from fsm_calib.recording.wheel_stamps import held, middle_of, travel
from fsm_calib.recording.writers import write_bag, write_recording
from fsm_calib.world2d.observation import predict
from fsm_calib.world2d.rollout import Drive

FACTS = RobotFacts(wheel_radius=Robot().radius, axle_length=Robot().axle)
RAMP = WheelPair(np.arange(5.0), 2.0 * np.arange(5.0), np.arange(5.0), "rad/s")


def with_rates(kind, seed=4, rate=20.0):
    """Return a simulated drive whose wheel rates are means since the row before ("end") or until the next ("start"),
    or samples ("middle")."""
    drive = driven(seed=seed, rate=rate)
    angles = np.column_stack([drive.wheel_angle.left, drive.wheel_angle.right])
    time, step = drive.pose.time, np.diff(drive.pose.time)[:, None]
    means, still = np.diff(angles, axis=0) / step, np.zeros((1, 2))
    rates = {"end": np.vstack([still, means]), "start": np.vstack([means, still])}
    rates["middle"] = 0.5 * (rates["end"] + rates["start"])
    return Recording(robot=FACTS, pose=drive.pose, wheel_rate=WheelPair(time, *rates[kind].T, "rad/s"))


def with_point_samples(seed=4, rate=20.0, late=0.0):
    """Return a drive whose wheels, their motors 80 ms behind, are read at the poses' instants, stamped `late` [s]."""
    drive, span = driven(seed=seed, rate=rate), 5e-4
    half, time = 0.5 * Robot().axle * drive.twist.omega, drive.pose.time[1:]
    around = np.sort(np.concatenate([time - span, time + span]))
    commands = Drive(drive.twist.time, drive.twist.v - half, drive.twist.v + half)
    seen = predict(Robot().parameters(), commands, around, (0.2, -0.1, 0.3), wheel_times=around).wheel_angles
    rates = (seen[1::2] - seen[::2]) / (2.0 * span)
    return Recording(robot=FACTS, pose=drive.pose, wheel_rate=WheelPair(time + late, *rates.T, "rad/s"))


@pytest.mark.parametrize(("stamp", "first"), [(None, -0.5), ("middle", -0.5), ("start", 0.0), ("end", -1.0)])
def test_rates_hold_from_where_their_time_begins(stamp, first):
    assert held(dataclasses.replace(RAMP, stamp=stamp))[0] == pytest.approx(np.arange(5.0) + first)


@pytest.mark.parametrize(("stamp", "middle"), [(None, 0.0), ("start", 0.5), ("end", -0.5)])
def test_the_middle_of_a_mean_lies_half_an_interval_beside_its_stamp(stamp, middle):
    assert middle_of(dataclasses.replace(RAMP, stamp=stamp)) == pytest.approx(np.arange(5.0) + middle)


@pytest.mark.parametrize(("stamp", "way"), [("middle", 16.0), ("start", 12.0), ("end", 20.0)])
def test_travel_sums_each_rate_over_its_own_time(stamp, way):
    assert travel(dataclasses.replace(RAMP, stamp=stamp))[1][-1] == pytest.approx(way)


def test_differences_of_angles_stamped_at_the_end_travel_as_the_angles():
    angles, wheels = driven(seed=4).wheel_angle, with_rates("end").wheel_rate
    told = wheels_of(Recording(wheel_rate=dataclasses.replace(wheels, stamp="end")))
    assert told.left == pytest.approx(angles.left - angles.left[0], abs=1e-9)


def test_poses_tell_means_since_the_row_before():
    (found,), _, sentence = with_stamps([with_rates("end")])
    assert found.wheel_rate.stamp == "end"
    assert "means since the row before" in sentence


@pytest.mark.parametrize("kind", ["middle", "start"])
def test_poses_that_are_not_early_leave_the_rates_as_samples(kind):
    (found,), _, sentence = with_stamps([with_rates(kind)])
    assert (found.wheel_rate.stamp, sentence) == (None, "")


def test_what_the_manifest_states_is_not_asked_of_the_poses():
    stated = with_rates("end")
    stated = dataclasses.replace(stated, wheel_rate=dataclasses.replace(stated.wheel_rate, stamp="middle"))
    (found,), _, sentence = with_stamps([stated])
    assert (found.wheel_rate.stamp, sentence) == ("middle", "")


def test_a_holdout_is_read_as_the_recordings_that_are_fitted():
    _, (held,), _ = with_stamps([with_rates("end")], [with_rates("end", seed=5)])
    assert held.wheel_rate.stamp == "end"


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "stamp"), [("end", None), ("start", "start")])
def test_a_robot_told_by_means_of_its_wheel_rates_matches(kind, stamp):
    recording = with_rates(kind)
    pair = dataclasses.replace(recording.wheel_rate, stamp=stamp)
    assert diagnose([dataclasses.replace(recording, wheel_rate=pair)]).verdict.verdict == "match"


def test_samples_are_moved_by_what_they_leave_open_of_the_bends_between_them():
    recording = with_point_samples()
    (found,), _, sentence = with_bends([recording])
    assert 0.001 < np.mean(recording.wheel_rate.time - found.wheel_rate.time) < 0.05 / 6.0
    assert "leave open" in sentence


@pytest.mark.parametrize("late", [-0.02, 0.02])
def test_what_no_sampling_does_is_left_to_be_named(late):
    assert with_bends([with_point_samples(late=late)])[2] == ""


def test_means_and_set_points_leave_nothing_open_between_them():
    recording = with_rates("end")
    recording = dataclasses.replace(
        recording, wheel_rate=dataclasses.replace(recording.wheel_rate, stamp="end")
    )
    assert with_bends([recording])[2] == ""


@pytest.mark.slow
def test_a_robot_told_by_point_samples_of_lagging_wheels_matches():
    assert diagnose([with_point_samples()]).verdict.verdict == "match"


def test_a_stamp_is_read_from_tables_and_written_again(tmp_path):
    recording = with_rates("end")
    recording = dataclasses.replace(
        recording, wheel_rate=dataclasses.replace(recording.wheel_rate, stamp="end")
    )
    assert read_recording(write_recording(recording, tmp_path / "table")).wheel_rate.stamp == "end"
    assert read_recording(write_bag(recording, tmp_path / "bag")).wheel_rate.stamp == "end"


def test_a_stamp_beside_a_duration_is_refused(tmp_path):
    (tmp_path / "recording.yaml").write_text(
        "format: fsm-calib/recording@1\nchannels:\n"
        "  wheel_rate: {file: w.csv, duration: d, left: l, right: r, stamp: end}\n"
    )
    with pytest.raises(FsmCalibError, match="leave stamp out"):
        read_recording(tmp_path)
