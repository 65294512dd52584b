"""A robot on a network behind `ports.Robot`: wheels by the guard, frames by their stamps."""

from __future__ import annotations

import contextlib
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator

from fsm_calib.errors import LinkLost, RobotLost
from fsm_calib.robots.camera import Decode, StampedCamera
from fsm_calib.robots.guard.client import GuardClient
from fsm_calib.robots.guard.setup import GuardSetup
from fsm_calib.types import Frame, WheelCommand

SPARE = 5.0
"""What a timed command may take longer than its time before the link counts as lost [s]."""
LOOK_STEP = 0.01
"""Steps of a look in lockstep [s]: fine against the delays that are served."""
FRAME_WAIT = 60.0
"""Longest wait for a frame that a served robot in lockstep has sent [s]: a loaded machine only takes longer."""
LOCKSTEP_SPARE = 300.0
"""The same in lockstep, where a loaded machine only takes longer [s]."""
ZEROS, ZERO_PAUSE = 5, 0.03
"""How often the program itself sends zero when the guard is dead, and the pause between two [s]."""


class GuardedRobot(ABC):
    """See `ports.Robot`; every call may raise `RobotLost`. A kind of robot says how its network is joined.

    Parameters
    ----------
    setup : GuardSetup
        The robot's address, and the guard's rules.
    decode : callable
        Returns the image of JPEG bytes, or None.
    """

    least_bound = 0.0
    """Least bound of a frame's age at its stamp [s], where the settings say less."""

    def __init__(self, setup: GuardSetup, decode: Decode) -> None:
        self._setup, self._settings = setup, setup.settings
        self._bound = max(setup.settings.camera_bound, self.least_bound)
        self._began, self._time = time.monotonic(), 0.0
        self._frames, self._main, self._closed = 0, time.monotonic(), False
        self._waiting, self._first_frame = False, -1
        self._step_end = 0.0
        self.camera = StampedCamera(self._arrival, decode)
        try:
            self._join()
            self.guard = GuardClient(setup, self._zero)
        except BaseException:
            self._leave()
            raise
        if setup.lockstep:
            self._wait(LOOK_STEP, False)
            self._step_end = self._time
            self.camera.forget()  # what was on its way to an earlier client arrived at a time of no meaning
            self._first_frame = self.guard.said.get("frame", -1)
        else:
            self._began = time.monotonic()
            threading.Thread(target=self._beat, daemon=True, name="beat").start()

    @abstractmethod
    def _join(self) -> None:
        """Join the robot's network and hand its frames to `camera`.

        Raises
        ------
        LinkLost
            The robot does not answer, or has no camera.
        """

    @abstractmethod
    def _leave(self) -> None:
        """Leave the network, whatever of it was joined."""

    @abstractmethod
    def _send_zero(self) -> None:
        """Put the wheels to zero without the guard, once."""

    def now(self) -> float:
        """Return the time since the connection [s]; in lockstep the served robot's."""
        return self._time if self._setup.lockstep else time.monotonic() - self._began

    def _arrival(self) -> float:
        """Return the time at which a frame arrives now [s]; in lockstep the end of the present step, not its begin."""
        return self._step_end if self._setup.lockstep else self.now()

    def command(self, command: WheelCommand) -> None:
        """Hold a command until the next one."""
        self._main = time.monotonic()
        self.guard.send("hold", command.left, command.right)

    def run(self, command: WheelCommand, duration: float) -> None:
        """Apply a command for `duration` [s]; the guard times it and sends the zero."""
        lockstep = self._setup.lockstep
        spare = LOCKSTEP_SPARE if lockstep else SPARE
        self._step_end = self._time + duration
        with self._alive():
            self.guard.ask("run", command.left, command.right, duration, timeout=duration + spare)
        self._learn_time()

    def wait(self, duration: float) -> None:
        """Let time pass while the wheels keep their last command."""
        if self._setup.lockstep:
            self._wait(duration, False)
            return
        with self._alive():
            self.guard.rest(duration)

    def _wait(self, duration: float, look: bool) -> None:
        """Let the served robot's time pass."""
        self._step_end = self._time + duration
        self.guard.ask("wait", duration, look, timeout=LOCKSTEP_SPARE)
        self._learn_time()

    def _learn_time(self) -> None:
        """Take the served robot's time over, in lockstep."""
        if self._setup.lockstep:
            self._time = float(self.guard.said.get("time", self._time))

    def capture(self) -> Frame | None:
        """Return a frame taken from now on; None when none came in time."""
        asked, bound = self.now(), self._bound
        found = self._stepped(asked, bound) if self._setup.lockstep else self._awaited(asked, bound)
        if found is None:
            return None
        self._frames += 1
        return self.camera.frame_of(found, bound, self._frames - 1)

    def _awaited(self, asked: float, bound: float) -> tuple[float, bytes] | None:
        """Wait for a frame in real time."""
        with self._alive():
            end = time.monotonic() + self._settings.frame_timeout
            while time.monotonic() < end:
                if self.camera.wait_for(lambda: self.camera.after(asked, bound) is not None, 0.02):
                    return self.camera.after(asked, bound)
                self.guard.check()
        return None

    def _stepped(self, asked: float, bound: float) -> tuple[float, bytes] | None:
        """Let the served robot's time pass until it sends a frame."""
        while self._time < asked + self._settings.frame_timeout:
            self._wait(LOOK_STEP, True)
            self._receive(self.guard.said.get("frame", -1))
            found = self.camera.after(asked, bound)
            if found is not None:
                return found
        return None

    def _receive(self, number: int) -> None:
        """Wait until frame `number`, the last one that the served robot sent, has arrived."""
        if number != self._first_frame:
            self.camera.wait_for(lambda: self.camera.last_number == number, FRAME_WAIT)

    @contextlib.contextmanager
    def _alive(self) -> Iterator[None]:
        """The program waits on purpose: it does not hang."""
        self._waiting = True
        try:
            yield
        finally:
            self._waiting, self._main = False, time.monotonic()

    def _beat(self) -> None:
        """Tell the guard that the program lives, as long as it waits or has not computed for too long."""
        while not self._closed:
            if self._waiting or time.monotonic() - self._main < self._settings.patience:
                with contextlib.suppress(RobotLost):
                    self.guard.send("beat")
            time.sleep(self._settings.resend)

    def _zero(self) -> None:
        """Put the wheels to zero without the guard."""
        for _ in range(ZEROS):
            self._send_zero()
            time.sleep(ZERO_PAUSE)

    def close(self) -> None:
        """Stop the wheels and end the connection; may be called twice."""
        if self._closed:
            return
        self._closed = True
        self.guard.close()
        self._leave()


def wait_until(condition: Callable[[], bool], problem: str, timeout: float = 10.0) -> None:
    """Wait for a condition.

    Raises
    ------
    LinkLost
        It does not come in time.
    """
    end = time.monotonic() + timeout
    while not condition():
        if time.monotonic() > end:
            raise LinkLost(problem, cure="Check the vehicle's name, and that its drivers run.")
        time.sleep(0.02)
