"""The guard in lockstep: acknowledgements are waited for, so that a slow machine changes nothing."""

from __future__ import annotations

import json
import threading
from queue import Empty, Queue
from typing import Any

import pytest

from fsm_calib.robots.address import RobotAddress
from fsm_calib.robots.guard.lockstep import Stepping
from fsm_calib.robots.guard.outlet import Event
from fsm_calib.robots.guard.process import Guard
from fsm_calib.robots.guard.setup import GuardSetup
from fsm_calib.robots.served.settings import ServeSettings
from fsm_calib.robots.served.station import Station
from fsm_calib.robots.settings import LinkSettings
from fsm_calib.robots.stepper import Stepper
from fsm_calib.types import WheelCommand
from fsm_calib.world2d.robot import WorldSpec, make_world

SETUP = GuardSetup(RobotAddress("ros1", "127.0.0.1", 1, "duckie"), LinkSettings(lockstep=True, dither=False))


class LateInbox(Queue[Event]):
    """An inbox on a machine so loaded that an acknowledgement is there only for who waits for it."""

    def __init__(self) -> None:
        super().__init__()
        self.on_their_way: list[Event] = []

    def get_nowait(self) -> Event:
        raise Empty

    def get(self, block: bool = True, timeout: float | None = None) -> Event:
        if not self.on_their_way:
            raise Empty
        return self.on_their_way.pop(0)


class Unheard:
    """An outlet of a served robot to which nobody listens."""

    def frame(self, number: int, stamp: float, image: object) -> None:
        pass

    def executed(self, command: WheelCommand, number: int, time: float) -> None:
        pass

    def ticks(self, side: str, count: int, time: float) -> None:
        pass

    def tracked(self, pose: object, time: float) -> None:
        pass


class Robot:
    """The outlet and the stepper of a robot that applies every command in the next step, the first ones `late` [s]."""

    def __init__(self, inbox: LateInbox, step: float, late: float = 0.0) -> None:
        self.inbox, self.sent, self.applied = inbox, 0, 0
        self.late = late
        self._commands: list[WheelCommand] = []
        self.said: dict[str, Any] = {"time": 0.0, "step": step, "frame": -1, "taken": 0, "executed": 0}

    def send(self, command: WheelCommand) -> None:
        self._commands.append(command)
        self.sent += 1

    def step(self, until: float, commands: int, look: bool) -> float:
        for command in self._commands if until > self.late else []:
            self.applied += 1
            self.inbox.on_their_way.append(("executed", command, self.applied))
        self._commands = self._commands if until <= self.late else []
        self.said |= {"time": until, "taken": self.sent, "executed": self.applied}
        return until


def test_an_acknowledgement_that_is_late_on_this_machine_is_not_taken_for_somebody_elses() -> None:
    inbox = LateInbox()
    robot = Robot(inbox, step=0.01)
    guard = Guard(SETUP, robot, inbox)
    stepping = Stepping(guard, robot, SETUP)
    for _ in range(3):
        stepping.obey(["run", 1, 0.2, 0.2, 1.0])
        stepping.obey(["wait", 2, 4.0, False])
    assert inbox.on_their_way == []
    assert guard.rules.stopped is None


def test_what_a_client_before_drove_is_not_held_against_this_one_however_late_it_acts() -> None:
    inbox = LateInbox()
    robot = Robot(inbox, step=0.01, late=0.08)
    robot.send(WheelCommand(0.5, -0.5))
    guard = Guard(SETUP, robot, inbox)
    stepping = Stepping(guard, robot, SETUP)
    stepping.begin()
    for _ in range(3):
        stepping.obey(["run", 1, 0.2, 0.2, 1.0])
        stepping.obey(["wait", 2, 4.0, False])
    assert inbox.on_their_way == []
    assert guard.rules.stopped is None


def test_a_command_of_somebody_else_still_stops_it() -> None:
    inbox = LateInbox()
    robot = Robot(inbox, step=0.01)
    guard = Guard(SETUP, robot, inbox)
    stepping = Stepping(guard, robot, SETUP)
    robot.send(WheelCommand(-0.7, 0.7))
    stepping.obey(["wait", 1, 0.1, False])
    assert guard.rules.stopped is not None
    assert "Somebody else drives" in guard.rules.stopped.problem


def test_a_client_leaves_answers_to_others_and_to_earlier_questions_aside() -> None:
    def ask(text: str) -> None:
        question = json.loads(text)
        others = question | {"client": "another", "time": 7.0}, question | {"number": 0, "time": 8.0}
        for answer in (*others, question | {"time": question["until"]}):
            stepper.hear(json.dumps(answer))

    stepper = Stepper(ask)
    assert [stepper.step(until, 0, False) for until in (0.5, 1.0)] == [0.5, 1.0]


def test_what_a_client_before_asked_and_still_waits_is_dropped_when_the_next_one_begins() -> None:
    station = Station(make_world(WorldSpec()), ServeSettings(), Unheard(), lockstep=True)
    answers: list[dict[str, Any]] = []
    asked = {"until": 0.5, "commands": 1, "look": False}
    waiting = threading.Thread(
        target=station.step, args=({"client": "gone", "number": 4, **asked}, answers.append)
    )
    station.step({"client": "gone", "number": 3, **asked, "until": 0.1, "commands": 0}, answers.append)
    waiting.start()
    station.step({"client": "new", "number": 1, **asked, "until": 0.2, "commands": 0}, answers.append)
    waiting.join()
    assert [(said["client"], said["time"]) for said in answers] == [
        ("gone", pytest.approx(0.1)),
        ("new", pytest.approx(0.2)),
    ]
