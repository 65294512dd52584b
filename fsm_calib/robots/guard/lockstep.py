"""The guard of a served robot in lockstep: the same rules, with the robot's own time in place of the wall's."""

from __future__ import annotations

from queue import Empty
from typing import Any

from fsm_calib.errors import RobotLost
from fsm_calib.robots.guard.process import Guard, tell
from fsm_calib.robots.guard.setup import GuardSetup
from fsm_calib.robots.ros1.outlet import Ros1Outlet
from fsm_calib.robots.ros1.stepper import Stepper
from fsm_calib.robots.ros1.topics import Topics
from fsm_calib.types import STOP, WheelCommand


def serve_in_lockstep(guard: Guard, setup: GuardSetup) -> None:
    """Guard until the program ends: every ``run`` and ``wait`` is a stretch of the robot's time."""
    outlet = guard.outlet
    if not isinstance(outlet, Ros1Outlet):
        raise TypeError("only a ROS 1 robot is served in lockstep")
    stepping = _Stepping(guard, outlet, Stepper(outlet.node, Topics(setup.address.vehicle)), setup)
    stepping.pass_time(stepping.step, False)
    while not guard.ended:
        event = guard.inbox.get()
        try:
            if event[0] == "line":
                stepping.obey(event[1])
            else:
                guard.take(event, stepping.now)
        except RobotLost as lost:
            guard.rules.stop(type(lost).__name__, lost.problem, lost.cure)
        if guard.rules.stopped is not None:
            guard.send(stepping.now)


class _Stepping:
    """The lines of the program, in the robot's time."""

    def __init__(self, guard: Guard, outlet: Ros1Outlet, stepper: Stepper, setup: GuardSetup) -> None:
        self._guard, self._outlet, self._stepper = guard, outlet, stepper
        self._resend = setup.settings.resend
        self.step = float(stepper.said["step"])
        self.now = float(stepper.said["time"])

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
            executed = self._stepper.said["executed"]
            until = self.now + now_ticks * self.step
            self.now = self._stepper.step(until, self._outlet.sent, look)
            if self._stepper.said["executed"] > executed:
                self._guard.rules.answered()
            self._guard.rules.hear(self.now)
            self._drain()
            if self._guard.rules.stopped is not None:
                return
            if ticks > 0 and self._guard.rules.held != STOP:
                self._guard.send(self.now)

    def _drain(self) -> None:
        """Take what was heard meanwhile; lines of the program wait for their turn."""
        lines = []
        try:
            while True:
                event = self._guard.inbox.get_nowait()
                if event[0] == "line":
                    lines.append(event)
                else:
                    self._guard.take(event, self.now)
        except Empty:
            for event in lines:
                self._guard.inbox.put(event)
