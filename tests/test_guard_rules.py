"""The guard's rules: what is sent to the wheels, and what stops them."""

from __future__ import annotations

import pytest

from fsm_calib.robots.guard.pwm import STEPS, Dither, floored
from fsm_calib.robots.guard.rules import Rules
from fsm_calib.robots.reckoning import Reckoning
from fsm_calib.robots.settings import LinkSettings
from fsm_calib.types import STOP, Pose2, WheelCommand

PLAIN = LinkSettings(dither=False)
AHEAD = WheelCommand(0.2, 0.2)


def rules(settings: LinkSettings = PLAIN, fence: float = 2.0) -> Rules:
    return Rules(settings, fence)


def driven(seconds: float, *, beat: bool = True, echo: bool = True, settings: LinkSettings = PLAIN) -> Rules:
    """Rules that held a command for `seconds`, with or without the program's and the driver's word."""
    guard = rules(settings)
    guard.hold(AHEAD, 0.0)
    for tick in range(round(seconds / settings.resend) + 1):
        now = tick * settings.resend
        if beat:
            guard.hear(now)
        command = guard.decide(now)
        if echo:
            guard.executed(command, now)
    return guard


def test_a_held_command_is_sent_until_the_next_one() -> None:
    guard = driven(3.0)
    assert guard.decide(3.05) == AHEAD
    guard.hold(STOP, 3.1)
    assert guard.decide(3.1) == STOP
    assert guard.stopped is None


def test_a_timed_command_ends_by_itself() -> None:
    guard = rules()
    guard.hold(AHEAD, 1.0, 0.1)
    assert guard.next_look(1.08) == pytest.approx(1.1)
    assert (guard.decide(1.0), guard.decide(1.1)) == (AHEAD, STOP)


def test_commands_are_cut_to_the_largest() -> None:
    guard = rules(LinkSettings(dither=False, largest_command=0.5))
    guard.hold(WheelCommand(0.9, -0.9), 0.0)
    assert guard.decide(0.0) == WheelCommand(0.5, -0.5)


def test_a_command_that_is_no_number_is_not_taken() -> None:
    guard = rules()
    guard.hold(WheelCommand(float("nan"), 0.1), 0.0)
    assert guard.decide(0.0) == STOP


def test_silence_while_driving_stops_for_good() -> None:
    guard = driven(0.3, beat=False)
    assert guard.stopped is not None
    assert guard.stopped.kind == "LinkLost"
    assert "silent" in guard.stopped.problem
    guard.hold(AHEAD, 1.0)
    assert guard.decide(1.0) == STOP


def test_silence_at_rest_is_no_reason_to_stop() -> None:
    guard = rules()
    guard.hold(STOP, 0.0)
    assert guard.decide(100.0) == STOP
    assert guard.stopped is None


def test_a_driver_that_acknowledges_nothing_stops_the_run() -> None:
    guard = driven(0.6, echo=False)
    assert guard.stopped is not None
    assert "acknowledged no command" in guard.stopped.problem


def test_a_foreign_command_stops_the_run() -> None:
    guard = driven(0.3)
    guard.executed(WheelCommand(-0.5, 0.5), 0.3)
    assert guard.stopped is not None
    assert guard.stopped.kind == "EmergencyStopped"
    assert "joystick" in guard.stopped.cure


def test_a_foreign_zero_and_an_echo_of_ours_that_is_late_are_no_reason_to_stop() -> None:
    guard = driven(0.3)
    guard.hold(STOP, 0.3)
    guard.decide(0.3)
    guard.executed(AHEAD, 0.45)
    guard.executed(STOP, 0.5)
    assert guard.stopped is None


def test_an_echo_of_ours_may_be_as_late_as_an_echo_may_be() -> None:
    guard = rules(LinkSettings(dither=False, echo=5.0))
    guard.hold(AHEAD, 0.0)
    guard.decide(0.0)
    guard.hold(STOP, 0.1)
    guard.decide(0.1)
    guard.executed(AHEAD, 4.9)
    assert guard.stopped is None
    guard.executed(AHEAD, 5.2)
    assert guard.stopped is not None


def test_beyond_the_fence_the_run_stops() -> None:
    guard = rules(fence=1.0)
    guard.reckoned(0.6, 0.6)
    assert guard.stopped is None
    guard.reckoned(0.8, 0.8)
    assert guard.stopped is not None
    assert "1.1 m from its start" in guard.stopped.problem


@pytest.mark.parametrize("command", [0.1, 0.2219, 0.23, -0.2219, 0.5, 0.011])
def test_dithered_commands_have_the_asked_mean_after_the_drivers_floor(command: float) -> None:
    dither = Dither()
    mean = sum(floored(dither(command)) for _ in range(400)) / 400
    assert mean == pytest.approx(command, abs=2.0 / (400 * STEPS))


def test_without_dither_the_floor_takes_up_to_a_step() -> None:
    assert floored(0.2219) == pytest.approx(43 / STEPS)
    assert 0.2219 - floored(0.2219) > 0.001


@pytest.mark.parametrize("command", [0.0, 0.005, -0.01])
def test_the_dead_zone_stays_dead(command: float) -> None:
    assert Dither()(command) == 0.0


def test_dead_reckoning_from_encoders_follows_a_turn() -> None:
    reckoning = Reckoning(Pose2(1.0, 2.0, 0.0))
    radius, axle = reckoning.wheels.wheel_radius, reckoning.wheels.axle_length
    for step in range(101):
        reckoning.encoder("left", -0.01 * step, 0.01 * step)
        reckoning.encoder("right", 0.01 * step, 0.01 * step)
    assert reckoning.pose.theta == pytest.approx(2.0 * radius / axle)
    assert (reckoning.pose.x, reckoning.pose.y) == pytest.approx((1.0, 2.0), abs=1e-3)


def test_dead_reckoning_rolls_out_backwards_though_the_encoders_count_forward() -> None:
    reckoning = Reckoning()
    reckoning.command(WheelCommand(-0.2, -0.2), 0.0)
    for step in range(101):
        for side in ("left", "right"):
            reckoning.encoder(side, -0.01 * step, 0.1)
    reckoning.command(WheelCommand(), 0.2)
    for step in range(51):
        for side in ("left", "right"):
            reckoning.encoder(side, -1.0 + 0.01 * step, 0.3)
    assert reckoning.pose.x == pytest.approx(-1.5 * reckoning.wheels.wheel_radius, rel=1e-4)


def test_dead_reckoning_from_commands_is_the_motor_constants() -> None:
    reckoning = Reckoning()
    for step in range(11):
        reckoning.command(AHEAD, 0.1 * step)
    assert reckoning.pose.x == pytest.approx(27.0 * 0.2 * 0.0318)
    assert reckoning.track().shape == (11, 4)
