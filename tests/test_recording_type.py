"""The recording type: immutable, cut, resampled."""

import numpy as np
import pytest
from recording_samples import every_channel

from fsm_calib.recording import PoseTrack, Recording, held_at, held_integral, resample_pose
from fsm_calib.types import Pose2


def test_arrays_of_a_channel_cannot_be_written():
    with pytest.raises(ValueError, match="read-only"):
        every_channel().pose.x[0] = 1.0


def test_channel_copies_what_it_is_given():
    x = np.zeros(3)
    track = PoseTrack(np.arange(3.0), x, x, x)
    x[0] = 5.0
    assert track.x[0] == 0.0


def test_recordings_with_the_same_numbers_are_equal():
    assert every_channel(1) == every_channel(1)


def test_recordings_with_other_numbers_differ():
    assert every_channel(1) != every_channel(2)


def test_unknown_headings_are_equal_to_each_other():
    track = PoseTrack(np.arange(3.0), np.zeros(3), np.zeros(3), np.full(3, np.nan))
    assert track == PoseTrack(np.arange(3.0), np.zeros(3), np.zeros(3), np.full(3, np.nan))


def test_a_row_of_a_track_is_a_pose():
    track = PoseTrack(np.arange(2.0), np.array([1.0, 2.0]), np.array([3.0, 4.0]), np.array([0.1, 0.2]))
    assert track.pose(1) == Pose2(2.0, 4.0, 0.2)


def test_window_keeps_measurements_inside_and_the_command_that_holds():
    recording = every_channel()
    t = recording.pose.time
    middle = (t[10] + t[11]) / 2.0
    part = recording.window(middle, t[20])
    assert part.pose.time[0] == t[11]
    assert part.pose.time[-1] == t[19]
    assert part.command.time[0] == t[10]


def test_windows_tile_the_span():
    recording = every_channel()
    start, end = recording.span
    parts = recording.windows(0.5)
    assert len(parts) == int((end - start) / 0.5 + 1e-9)


def test_gap_is_where_rows_are_missing():
    t = np.concatenate([np.arange(0.0, 1.0, 0.1), np.arange(2.0, 3.0, 0.1)])
    recording = Recording(pose=PoseTrack(t, t, t, t))
    assert recording.gaps("pose") == [(pytest.approx(0.9), pytest.approx(2.0))]


def test_heading_unwraps_across_pi():
    track = PoseTrack(np.arange(4.0), np.zeros(4), np.zeros(4), np.array([3.0, 3.1, -3.1, -3.0]))
    assert np.all(np.diff(track.heading) > 0.0)


def test_resampling_a_straight_turn_is_exact():
    t = np.arange(0.0, 2.0, 0.1)
    track = PoseTrack(t, 2.0 * t, -t, np.angle(np.exp(1j * 3.0 * t)))
    between = resample_pose(track, t[:-1] + 0.05)
    assert between.x == pytest.approx(2.0 * (t[:-1] + 0.05))
    assert between.theta == pytest.approx(3.0 * (t[:-1] + 0.05))


def test_resampling_tells_nothing_inside_a_gap():
    t = np.array([0.0, 0.1, 1.0, 1.1])
    between = resample_pose(PoseTrack(t, t, t, t), np.array([0.05, 0.5, 1.05]), longest_gap=0.3)
    assert list(np.isnan(between.x)) == [False, True, False]


def test_held_value_is_that_of_the_last_row():
    assert list(held_at(np.array([-1.0, 0.0, 0.5, 1.0]), np.array([0.0, 1.0]), np.array([3.0, 4.0]))) == [
        0,
        3,
        3,
        4,
    ]


def test_state_at_a_time_is_the_one_last_entered():
    state = every_channel().state
    assert state.at(float(state.time[1])) == "wheels.shuttling, back"
    assert state.at(-1.0) == ""


def test_what_is_held_adds_up_until_the_end():
    times, total = held_integral(np.array([1.0, 2.0, 4.0]), np.array([3.0, -1.0, 2.0]), end=5.0)
    assert times.tolist() == [1.0, 2.0, 4.0, 5.0]
    assert total.tolist() == [0.0, 3.0, 1.0, 3.0]
