"""Held up by an obstacle or by a dead wheel: driven a little back, only the latter turns the robot."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from fsm_calib.actions import Bench
from fsm_calib.actions.held_up import DRIVE_BLOCKED, why_held_up
from fsm_calib.actions.looking import look
from fsm_calib.types import Frame, WheelCommand

BLOCKS = np.random.default_rng(3).uniform(20.0, 220.0, (12, 30))
ROOM = cv2.resize(BLOCKS, (1200, 480), interpolation=cv2.INTER_CUBIC)
SIZE = (480, 640)


class Robot:
    """A robot whose picture moves by some columns to the right when it is driven."""

    def __init__(self, columns: int, frames: int = 9) -> None:
        self.columns, self.at, self.frames, self.driven = columns, 300, frames, []

    def run(self, command: WheelCommand, duration: float) -> None:
        self.driven.append((command, duration))
        self.at -= self.columns

    def wait(self, duration: float) -> None:
        pass

    def now(self) -> float:
        return 0.0

    def capture(self) -> Frame | None:
        self.frames -= 1
        room = ROOM[:, self.at : self.at + SIZE[1]] + np.random.default_rng(abs(self.frames)).normal(
            0.0, 2.0, SIZE
        )
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


@pytest.mark.parametrize("frames", [0, 1])
def test_where_no_picture_tells_an_obstacle_is_assumed(frames: int) -> None:
    assert why_held_up(bench_of(Robot(60, frames))) is DRIVE_BLOCKED
