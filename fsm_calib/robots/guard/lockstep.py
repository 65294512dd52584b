"""The guard of a served robot in lockstep: the same rules, with the robot's own time in place of the wall's."""

from __future__ import annotations

import time
from queue import Empty
from typing import Any

from fsm_calib.errors import RobotLost
from fsm_calib.robots.guard.outlet import Event
from fsm_calib.robots.guard.process import Guard, tell
from fsm_calib.robots.guard.setup import GuardSetup
from fsm_calib.robots.stepper import Stepper
from fsm_calib.types import STOP, WheelCommand

ECHO_WAIT = 30.0
"""Longest wait for an acknowledgement that is on its way [s]: a loaded machine only takes longer."""


def serve_in_lockstep(guard: Guard, setup: GuardSetup) -> None:
    """Guard until the program ends: every ``run`` and ``wait`` is a stretch of the robot's time."""
    stepping = Stepping(guard, guard.outlet.stepper(), setup)
    stepping.begin()
    while not guard.ended:
        event = guard.inbox.get()
        try:
            if event[0] == "line":
                stepping.obey(event[1])
            else:
                stepping.hear(event)
        except RobotLost as lost:
            guard.rules.stop(type(lost).__name__, lost.problem, lost.cure)
        if guard.rules.stopped is not None:
            guard.send(stepping.now)


class Stepping:
    """The lines of the program, in the robot's time."""

    def __init__(self, guard: Guard, stepper: Stepper, setup: GuardSetup) -> None:
        self._guard, self._outlet, self._stepper = guard, guard.outlet, stepper
        self._resend = setup.settings.resend
        self.step = float(stepper.said["step"])
        self.now = float(stepper.said["time"])
        self._echoes = self._others = 0

    def begin(self) -> None:
        """Let the first step pass; what the robot has taken before is another's, whenever it is applied and heard."""
        self.now = self._stepper.step(self.now + self.step, 0, False)
        self._others = int(self._stepper.said["taken"])
        self._echoes = int(self._stepper.said["executed"])
        self._drain()

    def obey(self, line: list[Any]) -> None:
        """Do what a line says; a ``run`` ends with zero on its way."""
        rules = self._guard.rules
        if line[0] == "hold":
            rules.hold(WheelCommand(line[1], line[2]), self.now)
            self._guard.send(self.now)
        elif line[0] == "run":
            _, number, left, right, seconds = line
            rules.hold(WheelCommand(left, right), self.now)
            self._guard.send(self.now)
            self.pass_time(seconds, False)
            rules.hold(STOP, self.now)
            self._guard.send(self.now)
            self._done(number)
        elif line[0] == "wait":
            _, number, seconds, look = line
            self.pass_time(seconds, look)
            self._done(number)

    def _done(self, number: int) -> None:
        said = self._stepper.said
        pose = self._guard.reckoning.pose
        tell({"done": number, "time": self.now, "frame": said["frame"], "pose": [pose.x, pose.y, pose.theta]})

    def pass_time(self, seconds: float, look: bool) -> None:
        """Let whole steps of time pass; a command that is held is sent again on the way."""
        ticks, each = round(seconds / self.step), max(round(self._resend / self.step), 1)
        while ticks > 0:
            now_ticks = min(ticks, each) if self._guard.rules.held != STOP else ticks
            ticks -= now_ticks
            until = self.now + now_ticks * self.step
            self.now = self._stepper.step(until, self._outlet.sent, look)
            self._guard.rules.hear(self.now)
            self._hear_echoes()
            if self._guard.rules.stopped is not None:
                return
            if ticks > 0 and self._guard.rules.held != STOP:
                self._guard.send(self.now)

    def _hear_echoes(self) -> None:
        """Take every acknowledgement of what the robot says that it applied: in its time none comes later."""
        lines: list[Event] = []
        end = time.monotonic() + ECHO_WAIT
        while self._echoes < self._stepper.said["executed"]:
            try:
                self._take(self._guard.inbox.get(timeout=max(end - time.monotonic(), 0.0)), lines)
            except Empty:
                self._echoes = int(self._stepper.said["executed"])  # one was published before we listened
        self._drain(lines)

    def _drain(self, lines: list[Event] | None = None) -> None:
        """Take what was heard meanwhile; lines of the program wait for their turn."""
        lines = [] if lines is None else lines
        try:
            while True:
                self._take(self._guard.inbox.get_nowait(), lines)
        except Empty:
            for event in lines:
                self._guard.inbox.put(event)

    def _take(self, event: Event, lines: list[Event]) -> None:
        """Take one event; a line of the program is put aside."""
        if event[0] == "line":
            lines.append(event)
        else:
            self.hear(event)

    def hear(self, event: Event) -> None:
        """Take what is no line of the program; what was applied for a client before says nothing about this one."""
        if event[0] == "executed":
            self._echoes = max(self._echoes, event[2])
            if event[2] <= self._others:
                return
        self._guard.take(event, self.now)
