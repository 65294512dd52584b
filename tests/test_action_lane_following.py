"""What one stretch of lane following does where frames are lost."""

from __future__ import annotations

import numpy as np
import pytest

from fsm_calib.actions import Bench, lane_driving
from fsm_calib.actions.lane_driving import follow_lane
from fsm_calib.actions.looking import FRAME_FROZEN, FRAME_MISSING
from fsm_calib.outcome import Outcome
from fsm_calib.types import STOP, Frame, LanePose, WheelCommand

SEEN = LanePose(0.0, 0.0, 100)


class Wheels:
    """Wheels that write down what they were told, and a clock."""

    def __init__(self) -> None:
        self.commands: list[WheelCommand] = []
        self.time = 0.0

    def command(self, command: WheelCommand) -> None:
        self.commands.append(command)

    def wait(self, duration: float) -> None:
        self.time += duration

    def now(self) -> float:
        return self.time


def followed(monkeypatch: pytest.MonkeyPatch, *lost: Outcome | None) -> tuple[Outcome, list[WheelCommand]]:
    """Return the outcome of a stretch whose looks are lost so, or see the lane, and what the wheels were told."""
    left, bench = list(lost), Bench(Wheels())

    def look(bench: Bench) -> Frame | Outcome:
        return left.pop(0) or Frame(np.zeros((2, 2, 3), np.uint8), bench.robot.now(), 0)

    monkeypatch.setattr(lane_driving, "look", look)
    monkeypatch.setattr(lane_driving, "tags_in", lambda bench, frame: ())
    monkeypatch.setattr(lane_driving, "observe_lane", lambda *given: SEEN)
    return follow_lane(bench), bench.robot.commands


def test_a_frame_that_does_not_come_stops_the_robot_until_the_next_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    outcome, commands = followed(monkeypatch, None, FRAME_MISSING, None, None)
    assert outcome.trigger == "lane_followed"
    assert [command == STOP for command in commands] == [False, True, False, False]


def test_a_stretch_without_any_frame_is_a_loss(monkeypatch: pytest.MonkeyPatch) -> None:
    outcome, commands = followed(monkeypatch, *[FRAME_MISSING] * 4)
    assert outcome is FRAME_MISSING
    assert set(commands) == {STOP}


def test_a_frozen_frame_ends_the_stretch_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    outcome, commands = followed(monkeypatch, None, FRAME_FROZEN)
    assert outcome is FRAME_FROZEN
    assert commands[-1] == STOP
