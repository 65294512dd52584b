"""What a person would notice in a recording is told, and what was dropped is said."""

import numpy as np
import pytest
from recording_samples import shared

from fsm_calib.errors import InputError
from fsm_calib.recording import CommandTrack, PoseTrack, Recording, WheelPair, read_recording
from fsm_calib.recording.checks import checked


class Nowhere:
    def where(self, row: int) -> str:
        return f"row {row}"


def looked_at(**channels) -> Recording:
    return checked(Recording(**channels), dict.fromkeys(channels, Nowhere()))


def circle(**changes) -> PoseTrack:
    t = np.arange(0.0, 20.0, 0.1)
    columns = {"time": t, "x": np.sin(t / 3.0), "y": 1.0 - np.cos(t / 3.0), "theta": t / 3.0} | changes
    return PoseTrack(**columns)


def kinds(recording: Recording) -> set[str]:
    return {finding.kind for finding in recording.checks}


def test_sound_drive_has_no_findings():
    assert looked_at(pose=circle()).checks == ()


def test_row_whose_time_goes_backwards_is_dropped_and_told():
    t = circle().time.copy()
    t[50] = 1.0
    recording = looked_at(pose=circle(time=t))
    assert len(recording.pose) == 199
    finding = recording.checks[0]
    assert (finding.kind, finding.action, finding.rows) == ("time_backwards", "dropped", 1)


def test_rows_that_neighbours_overtook_are_sorted_and_told():
    order = np.arange(200)
    order[10:190:2], order[11:191:2] = order[11:191:2].copy(), order[10:190:2].copy()
    plain = circle()
    recording = looked_at(pose=plain.rows(order))
    assert recording.pose == plain
    assert kinds(recording) == {"unsorted"}


def test_later_of_two_commands_at_one_instant_holds():
    track = CommandTrack(np.array([0.0, 1.0, 1.0, 2.0]), np.array([0.0, 0.1, 0.2, 0.3]), np.zeros(4))
    assert list(looked_at(command=track).command.left) == [0.0, 0.2, 0.3]


def test_measurements_at_one_instant_are_spread():
    track = WheelPair(np.array([0.0, 1.0, 1.0, 2.0]), np.arange(4.0), np.arange(4.0))
    assert list(looked_at(wheel_angle=track).wheel_angle.time) == [0.0, 1.0, 1.5, 2.0]


def test_a_measurement_whose_rows_all_have_one_instant_is_spread_over_a_second():
    still = PoseTrack(time=np.zeros(2), x=np.array([1.0, 7.0]), y=np.zeros(2), theta=np.zeros(2))
    assert looked_at(pose=still).pose.time == pytest.approx([0.0, 0.5])


def test_jump_is_told_with_its_time():
    x = circle().x.copy()
    x[100] += 2.0
    finding = looked_at(pose=circle(x=x)).checks[0]
    assert finding.kind == "jump"
    assert finding.time == pytest.approx(10.0)


def test_millimetres_that_nobody_stated_are_read_as_such_and_told():
    found = looked_at(pose=circle(x=1000.0 * circle().x, y=1000.0 * circle().y))
    assert found.pose.x == pytest.approx(circle().x)
    assert any("read as mm" in str(finding) for finding in found.checks)


def test_metres_that_are_stated_and_impossible_are_refused():
    recording = Recording(pose=circle(x=1000.0 * circle().x, y=1000.0 * circle().y))
    with pytest.raises(InputError, match="wrong unit"):
        checked(recording, {"pose": Nowhere()}, stated={"pose.length"})


def test_many_impossible_steps_are_told():
    x = circle().x.copy()
    x[40:60:2] += 5.0
    assert "unit_slip" in kinds(looked_at(pose=circle(x=x)))


def test_pose_frozen_under_drive_is_told():
    x, y = circle().x.copy(), circle().y.copy()
    x[60:120], y[60:120] = x[60], y[60]
    command = CommandTrack(np.array([0.0]), np.array([0.3]), np.array([0.32]))
    track = CommandTrack(np.array([0.0, 20.0]), np.array([0.3, 0.3]), np.array([0.32, 0.32]))
    assert "frozen" in kinds(looked_at(pose=circle(x=x, y=y), command=track))
    assert "frozen" not in kinds(looked_at(pose=circle(), command=command))


def test_wheel_that_never_moves_is_told():
    t = np.arange(10.0)
    assert "frozen" in kinds(looked_at(wheel_rate=WheelPair(t, np.zeros(10), t, "rad/s")))


def test_clocks_with_different_zeros_are_told():
    t = circle().time
    track = CommandTrack(t + 1.6e9, np.full(200, 0.1), np.full(200, 0.2))
    assert "clocks" in kinds(looked_at(command=track, pose=circle()))


def test_gap_is_told():
    keep = (circle().time < 5.0) | (circle().time > 8.0)
    assert "gap" in kinds(looked_at(pose=circle().rows(keep)))


@pytest.mark.parametrize(
    "name", ["duckiebot-watchtower/b1-run1", "husky-skidsteer/run0", "mrclam-create/ds6-robot3"]
)
def test_real_robots_are_read_without_refusal(name):
    assert read_recording(shared(f"{name}.recording.yaml")).channels


def test_one_stamp_of_another_clock_costs_its_own_row_only():
    t = circle().time.copy()
    t[100] = 1e6
    recording = looked_at(pose=circle(time=t))
    assert (len(recording.pose), recording.checks[0].rows) == (199, 1)


def test_hole_longer_than_any_drive_is_refused_with_its_row():
    t = circle().time.copy()
    t[-1] = 1e6
    with pytest.raises(InputError, match=r"row 199: .*no row for 1e\+06 s"):
        looked_at(pose=circle(time=t))
