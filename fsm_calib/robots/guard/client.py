"""The program's side of the guard: starts it, talks to it, and puts the wheels to zero itself when it dies."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from typing import Any

from fsm_calib import errors
from fsm_calib.errors import LinkLost, RobotLost
from fsm_calib.robots.guard.setup import GuardSetup

START = 60.0
"""Longest wait for the guard to be ready [s]."""
PUSHES = {"hold": slice(1, 3), "run": slice(2, 4)}
"""Lines that ask for wheel commands, and where in them the two stand."""
DEAD_CURE = "The wheels were put to zero without it. Look at the robot, then go on."


class GuardClient:
    """A running guard.

    Parameters
    ----------
    setup : GuardSetup
        Its robot and rules.
    on_dead : callable
        Puts the wheels to zero by another way; called in a thread when the guard dies or hangs.

    Raises
    ------
    RobotLost
        The guard found no robot, or one that must not be driven.
    """

    def __init__(self, setup: GuardSetup, on_dead: Callable[[], None]) -> None:
        self._lockstep, self._on_dead, self._quiet = setup.lockstep, on_dead, setup.settings.quiet
        self._changed = threading.Condition()
        self._done = self._number = 0
        self._up = self._closed = self._asked = False
        self.stopped: RobotLost | None = None
        self.pose = [setup.start.x, setup.start.y, setup.start.theta]
        self.said: dict[str, Any] = {}
        self._spoke = self._began = time.monotonic()
        self.path = [(0.0, *self.pose)]
        self._process = subprocess.Popen(
            [sys.executable, "-m", "fsm_calib.robots.guard.process", setup.to_json()],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=True,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)},
        )
        threading.Thread(target=self._read, daemon=True, name="guard").start()
        self._wait_until_up()
        if not self._lockstep:
            threading.Thread(target=self._watch, daemon=True, name="guard-watch").start()

    @property
    def pid(self) -> int:
        """The guard's process."""
        return self._process.pid

    def _wait_until_up(self) -> None:
        """Wait for the guard's first word."""
        with self._changed:
            self._changed.wait_for(lambda: self._up or self.stopped is not None, START)
        if not self._up:
            self.close()
            raise self.stopped or LinkLost(f"the guard was not ready within {START:g} s")

    def _read(self) -> None:
        """Take the guard's lines until it ends; the wheels stand before the program is told, which may then leave."""
        for text in self._process.stdout or ():
            self._take(json.loads(text))
        if self._up and not self._closed:
            self._on_dead()
        with self._changed:
            self._fail(LinkLost("The guard of the wheels has ended", cure=DEAD_CURE))

    def _take(self, line: dict[str, Any]) -> None:
        """Take one line."""
        with self._changed:
            self._spoke = time.monotonic()
            self.said |= line
            self._asked &= not (self._turns or "done" in line)
            if "pose" in line:
                self._move(line["pose"])
            self._up |= "up" in line
            self._done = line.get("done", self._done)
            if "stopped" in line:
                kind, problem, cure = line["stopped"]
                self._fail(getattr(errors, kind, LinkLost)(problem, cure=cure))
            self._changed.notify_all()

    def _move(self, pose: list[float]) -> None:
        """Note where dead reckoning puts the robot."""
        if pose != self.pose:
            now = self.said.get("time", 0.0) if self._lockstep else time.monotonic() - self._began
            self.path.append((now, *pose))
        self.pose = pose

    def _fail(self, lost: RobotLost) -> None:
        """Keep the first reason."""
        if self.stopped is None and not self._closed:
            self.stopped = lost
        self._changed.notify_all()

    def _watch(self) -> None:
        """Put the wheels to zero when the guard hangs; it is ended, so that it cannot wake and go on.

        It speaks at every command that it sends, 20 times a second; as long as the program may, it may be silent. A
        push that it was asked for counts as one that turns the wheels: whether it was sent, a halted guard cannot say.
        """
        while not self._closed and self._process.poll() is None:
            time.sleep(0.02)
            if (self._asked or self._turns) and time.monotonic() - self._spoke > self._quiet:
                self._on_dead()
                with self._changed:
                    self._fail(LinkLost("The guard of the wheels hangs", cure=DEAD_CURE))
                self._process.kill()
                return

    @property
    def _turns(self) -> bool:
        """Whether the guard last said that the wheels turn."""
        return bool(self.said.get("left") or self.said.get("right"))

    def _ask_for(self, push: bool) -> None:
        """Note that a push is asked for: from then on the guard of wheels that stand may not be silent."""
        with self._changed:
            if push and not (self._asked or self._turns):
                self._spoke = time.monotonic()
            self._asked = push

    def send(self, *line: Any) -> None:
        """Send a line.

        Raises
        ------
        RobotLost
            The guard has stopped the wheels, or is gone.
        """
        self.check()
        if line[0] in PUSHES:
            self._ask_for(any(line[PUSHES[line[0]]]))
        try:
            stream = self._process.stdin
            if stream is not None:
                stream.write(json.dumps(line) + "\n")
                stream.flush()
        except (OSError, ValueError) as error:
            with self._changed:
                self._fail(LinkLost("The guard of the wheels has ended", cure=DEAD_CURE))
            self.check()
            raise LinkLost("The guard of the wheels has ended", cure=DEAD_CURE) from error

    def ask(self, name: str, *values: Any, timeout: float) -> None:
        """Send a line with a number and wait until it is done.

        Raises
        ------
        RobotLost
            The guard has stopped the wheels, is gone, or did not do it in time.
        """
        self._number += 1
        number = self._number
        self.send(name, number, *values)
        with self._changed:
            self._changed.wait_for(lambda: self._done >= number or self.stopped is not None, timeout)
        self.check()
        if self._done < number:
            raise LinkLost(f"The guard did not finish {name} within {timeout:g} s", cure=DEAD_CURE)

    def rest(self, duration: float) -> None:
        """Wait for `duration` [s], or until the guard stops.

        Raises
        ------
        RobotLost
            It has stopped the wheels.
        """
        with self._changed:
            self._changed.wait_for(lambda: self.stopped is not None, max(duration, 0.0))
        self.check()

    def check(self) -> None:
        """Raise the reason when the guard has stopped the wheels."""
        if self.stopped is not None:
            raise self.stopped

    def close(self) -> None:
        """End the guard, which puts the wheels to zero; where it could not, that is done here. May be called twice."""
        with self._changed:
            self._closed = True
        with contextlib.suppress(OSError):
            if self._process.stdin is not None:
                self._process.stdin.close()
        try:
            self._process.wait(timeout=10.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        if self._up and self._process.returncode != 0:
            self._on_dead()
