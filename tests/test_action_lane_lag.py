"""A pose in the lane is carried on over the lag of the frame that saw it."""

from __future__ import annotations

import math

import pytest

from fsm_calib.actions.lane_driving import eased
from fsm_calib.actions.lane_lag import predict
from fsm_calib.actions.settings import LaneSettings
from fsm_calib.types import LanePose, WheelCommand
from fsm_calib.world2d.robot import WorldSettings, WorldSpec, make_world

MODEL = {"speed": 1.0, "ratio": 1.0, "axle": 0.1, "answer": 0.0}
SEEN = LanePose(0.05, 0.1, 40)


def test_a_frame_without_lag_is_taken_as_it_is() -> None:
    assert predict(SEEN, 3.0, 3.0, [(0.0, WheelCommand(0.3, 0.1))], **MODEL) is SEEN


def test_a_straight_command_carries_the_robot_along_its_heading() -> None:
    ahead = [(0.0, WheelCommand(0.2, 0.2))]
    pose = predict(SEEN, 3.0, 3.5, ahead, **MODEL)
    assert (pose.d, pose.phi) == pytest.approx((0.05 + 0.2 * 0.5 * math.sin(0.1), 0.1))


def test_a_wheel_ratio_drives_straight_when_the_command_has_it() -> None:
    pose = predict(SEEN, 3.0, 3.5, [(0.0, WheelCommand(0.2, 0.22))], **{**MODEL, "ratio": 1.1})
    assert pose.phi == pytest.approx(0.1)


def test_only_what_acts_within_the_lag_counts() -> None:
    sent = [(0.0, WheelCommand(0.2, 0.2)), (3.1, WheelCommand(0.1, 0.3))]
    pose = predict(SEEN, 3.0, 3.2, sent, **MODEL)
    assert pose.phi == pytest.approx(0.1 + 0.1 * 0.2 / 0.1, abs=0.03)
    delayed = predict(SEEN, 3.0, 3.2, sent, **{**MODEL, "answer": 0.1})
    assert delayed.phi == pytest.approx(0.1 + 0.1 * 0.2 / 0.1, abs=0.03)


def test_before_the_first_command_the_robot_stands() -> None:
    assert predict(SEEN, 3.0, 3.5, [], **MODEL) == SEEN


def test_a_delayed_camera_hands_out_what_it_saw_before() -> None:
    robot = make_world(WorldSpec(settings=WorldSettings(camera_delay=0.1))).robot
    robot.wait(1.0)
    frame = robot.capture()
    assert frame is not None
    assert (frame.time, robot.now()) == pytest.approx((1.0, 1.1))


@pytest.mark.parametrize("lag", [0.1, 0.2, 0.4])
def test_late_frames_ease_the_gains_so_that_a_heading_shrinks_from_command_to_command(lag: float) -> None:
    settings = LaneSettings()
    held = settings.period + lag
    assert 1.0 - eased(settings, lag) * abs(settings.k_phi) * held == pytest.approx(0.2)


def test_frames_of_now_leave_the_gains_as_they_are() -> None:
    assert eased(LaneSettings(), 0.0) == 1.0


def test_gains_that_are_small_already_stay_when_frames_are_late() -> None:
    assert eased(LaneSettings(k_phi=-1.0), 0.2) == 1.0
