"""Held up by an obstacle or by a dead wheel: driven a little back, only the latter turns the robot."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from fsm_calib.actions import Bench
from fsm_calib.actions.held_up import DRIVE_BLOCKED, why_held_up
from fsm_calib.actions.looking import FRAME_FROZEN, FRAME_MISSING, look
from fsm_calib.types import Frame, WheelCommand

BLOCKS = np.random.default_rng(3).uniform(20.0, 220.0, (12, 30))
ROOM = cv2.resize(BLOCKS, (1200, 480), interpolation=cv2.INTER_CUBIC)
SIZE = (480, 640)


class Robot:
    """A robot whose picture moves by some columns to the right when it is driven."""

    def __init__(self, columns: int, frames: int = 9, noise: float = 2.0) -> None:
        self.columns, self.at, self.frames, self.noise, self.driven = columns, 300, frames, noise, []

    def run(self, command: WheelCommand, duration: float) -> None:
        self.driven.append((command, duration))
        self.at -= self.columns

    def wait(self, duration: float) -> None:
        pass

    def now(self) -> float:
        return 0.0

    def capture(self) -> Frame | None:
        self.frames -= 1
        noise = self.noise * np.random.default_rng(abs(self.frames)).normal(0.0, 1.0, SIZE)
        room = ROOM[:, self.at : self.at + SIZE[1]] + noise
        return None if self.frames < 0 else Frame(np.clip(room, 0, 255).astype(np.uint8), 0.0, 0)


def bench_of(robot: Robot) -> Bench:
    """Return a bench whose robot has just looked."""
    bench = Bench(robot)
    look(bench)
    return bench


@pytest.mark.parametrize("columns", [0, 12, -12])
def test_a_robot_that_comes_straight_away_met_an_obstacle(columns: int) -> None:
    assert why_held_up(bench_of(Robot(columns))) is DRIVE_BLOCKED


@pytest.mark.parametrize(("columns", "wheel"), [(60, "right"), (-60, "left")])
def test_a_robot_that_turns_about_a_wheel_has_that_one_dead(columns: int, wheel: str) -> None:
    told = why_held_up(bench_of(Robot(columns)))
    assert told.trigger == "wheel_stalled"
    assert told.evidence["wheel"] == wheel
    assert f"{wheel} motor" in told.cure


def test_it_is_driven_back_by_both_wheels_no_farther_than_a_picture_tells() -> None:
    robot = Robot(0)
    bench = bench_of(robot)
    bench.notebook.wheel_ratio = 0.9
    why_held_up(bench)
    ((command, duration),) = robot.driven
    assert command == WheelCommand(-bench.settings.drive.command, -0.9 * bench.settings.drive.command)
    assert duration * bench.settings.drive.expected_speed == pytest.approx(bench.settings.drive.told_back)


def test_where_no_picture_was_taken_before_an_obstacle_is_assumed() -> None:
    assert why_held_up(Bench(Robot(60))) is DRIVE_BLOCKED


def test_a_camera_that_froze_or_fell_silent_on_the_way_is_told() -> None:
    assert why_held_up(bench_of(Robot(60, frames=1))) is FRAME_MISSING
    assert why_held_up(bench_of(Robot(0, noise=0.0))) is FRAME_FROZEN
