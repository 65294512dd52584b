"""The guard's process: ``python -m fsm_calib.robots.guard.process SETUP``.

Lines of JSON on standard input: ``["hold", left, right]``, ``["run", number, left, right, seconds]``, ``["beat"]``, and
in lockstep ``["wait", number, seconds, look]``. The end of the input, silence while the wheels turn, a stop, a lost
link and a foreign command all end with zero on the wheels. Lines on standard output: ``{"up": true}``, ``{"alive":
time, "pose": [x, y, theta], "left", "right"}`` at every command sent (before a push, after zero), ``{"done":
number}``, ``{"stopped": [kind, problem, cure]}``.
"""

from __future__ import annotations

import contextlib
import json
import signal
import sys
import threading
import time
from queue import Empty, Queue
from typing import Any

from fsm_calib.errors import FsmCalibError, RobotLost
from fsm_calib.robots.guard.outlet import Event, Outlet, open_outlet
from fsm_calib.robots.guard.rules import SILENT_CURE, Rules
from fsm_calib.robots.guard.setup import GuardSetup
from fsm_calib.robots.reckoning import Reckoning
from fsm_calib.types import STOP, WheelCommand

LAST_ZEROS, ZERO_PAUSE = 5, 0.03
"""How often zero is sent before the guard ends, and the pause between two [s]."""
ALONE_EVERY = 1.0
"""Time between two looks for foreign publishers [s]."""
STOP_CURE = "See why it was pressed; the robot needs no restart."


class Guard:
    """One guard, from its start to its end.

    Parameters
    ----------
    setup : GuardSetup
        Robot and rules.
    outlet : Outlet
        The wheels.
    inbox : Queue
        What was heard, from everywhere.
    """

    def __init__(self, setup: GuardSetup, outlet: Outlet, inbox: Queue[Event]) -> None:
        self.outlet, self.inbox = outlet, inbox
        self.rules = Rules(setup.settings, setup.fence)
        self.reckoning = Reckoning(setup.start)
        self._start = setup.start
        self.running: int | None = None
        self._told = False
        self.ended = False

    def take(self, event: Event, now: float) -> bool:
        """Take an event; return whether a command must be sent at once."""
        kind = event[0]
        if kind == "line":
            return self._obey(event[1], now)
        if kind == "executed":
            self.rules.executed(event[1], now)
            self.reckoning.command(event[1], now)
            self._check_fence()
        elif kind == "angle":
            self.reckoning.encoder(event[1], event[2], now)
            self._check_fence()
        elif kind == "end":
            self.ended = True
            self.rules.stop("LinkLost", "The program has ended", "")
        else:
            name = "EmergencyStopped" if kind == "estop" else "LinkLost"
            self.rules.stop(name, event[1], STOP_CURE if kind == "estop" else SILENT_CURE)
        return self.rules.stopped is not None

    def _obey(self, line: list[Any], now: float) -> bool:
        """Do what a line from the program says."""
        if line[0] == "hold":
            self.rules.hold(WheelCommand(line[1], line[2]), now)
            return True
        if line[0] == "run":
            self.running = line[1]
            self.rules.hold(WheelCommand(line[2], line[3]), now, line[4])
            return True
        self.rules.hear(now)
        return False

    def _check_fence(self) -> None:
        pose = self.reckoning.pose
        self.rules.reckoned(pose.x - self._start.x, pose.y - self._start.y)

    def send(self, now: float) -> None:
        """Send what the rules decide, and tell the program.

        Where the guard is halted between the two, the program must take the wheels for turning: it is told of a push
        before the push is sent, and of zero after.
        """
        over = self.rules.is_over(now)
        command = self.rules.decide(now)
        pose = self.reckoning.pose
        said = {
            "alive": now,
            "pose": [pose.x, pose.y, pose.theta],
            "left": command.left,
            "right": command.right,
        }
        if command == STOP:
            self.outlet.send(command)
            tell(said)
        else:
            tell(said)
            self.outlet.send(command)
        if over and self.running is not None:
            tell({"done": self.running})
            self.running = None
        if self.rules.stopped is not None and not self._told:
            self._told = True
            stopped = self.rules.stopped
            tell({"stopped": [stopped.kind, stopped.problem, stopped.cure]})

    def serve(self) -> None:
        """Guard in real time, until the program ends."""
        look = time.monotonic()
        while not self.ended:
            try:
                event = self.inbox.get(timeout=max(look - time.monotonic(), 0.0))
                urgent = self.take(event, time.monotonic())
            except Empty:
                urgent = True
            now = time.monotonic()
            if urgent or now >= look:
                self.send(now)
                look = self.rules.next_look(now)

    def finish(self) -> None:
        """Send zeros until they have surely arrived, then leave."""
        for _ in range(LAST_ZEROS):
            with contextlib.suppress(FsmCalibError):
                self.outlet.send(STOP)
            time.sleep(ZERO_PAUSE)
        self.outlet.close()


def tell(line: dict[str, Any]) -> None:
    """Tell the program something; one that has gone hears nothing."""
    stream = sys.__stdout__
    if stream is not None:
        with contextlib.suppress(OSError, ValueError):
            stream.write(json.dumps(line) + "\n")
            stream.flush()


def read_lines(inbox: Queue[Event]) -> None:
    """Put the program's lines into the inbox, and its end."""
    for text in sys.stdin:
        with contextlib.suppress(ValueError):
            inbox.put(("line", json.loads(text)))
    inbox.put(("end",))


def watch_others(outlet: Outlet, inbox: Queue[Event], ended: threading.Event) -> None:
    """Look for foreign publishers now and then."""
    while not ended.wait(ALONE_EVERY):
        try:
            outlet.check_alone()
        except RobotLost as lost:
            inbox.put(("estop" if type(lost).__name__ == "EmergencyStopped" else "lost", lost.problem))


def main(text: str) -> None:
    """Run a guard."""
    setup, ended = GuardSetup.from_json(text), threading.Event()
    inbox: Queue[Event] = Queue()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda number, frame: inbox.put(("end",)))
    try:
        outlet = open_outlet(setup, inbox)
    except FsmCalibError as error:
        cure = getattr(error, "cure", "")
        tell({"stopped": [type(error).__name__, getattr(error, "problem", str(error)), cure]})
        return
    guard = Guard(setup, outlet, inbox)
    threading.Thread(target=read_lines, args=(inbox,), daemon=True).start()
    tell({"up": True})
    try:
        if setup.lockstep:
            from fsm_calib.robots.guard.lockstep import serve_in_lockstep

            serve_in_lockstep(guard, setup)
        else:
            threading.Thread(target=watch_others, args=(outlet, inbox, ended), daemon=True).start()
            guard.serve()
    finally:
        ended.set()
        guard.finish()


if __name__ == "__main__":
    with contextlib.redirect_stdout(sys.stderr):  # what a library prints is no line for the program
        main(sys.argv[1])
