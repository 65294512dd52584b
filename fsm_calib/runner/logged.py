"""A robot behind the same socket that keeps a log of what was asked of it.

The log is what makes a killed run resumable: a simulated world, driven by the same operations from the same
seed, ends in the same state, and no frame has to be rendered again on the way.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Sequence
from typing import Any, Protocol

from fsm_calib.errors import DataError
from fsm_calib.ports import Robot
from fsm_calib.types import STOP, Frame, WheelCommand

Operation = tuple[Any, ...]
"""``("command", left, right)``, ``("wait", seconds)`` or ``("frame",)``."""


class ReplayableRobot(Robot, Protocol):
    """A robot that can pass over a frame: state and noise as if it had been exposed, without an image."""

    def skip_frame(self) -> None:
        """Let everything happen that `capture` does, except the image."""
        ...


class LoggedRobot:
    """Passes every call on, logs it, and counts the seconds spent in physics and in the camera.

    Parameters
    ----------
    robot : Robot
        The robot that does the work.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.operations: list[Operation] = []
        self.last_frame: Frame | None = None
        self.frames = 0
        self.seconds = {"physics": 0.0, "camera": 0.0}

    def command(self, command: WheelCommand) -> None:
        """Apply a command; see `ports.WheelDrive`."""
        if not (math.isfinite(command.left) and math.isfinite(command.right)):
            raise DataError(
                f"a wheel command is no number: {command}", cure="Report this with the scenario and seed."
            )
        self.operations.append(("command", command.left, command.right))
        self.robot.command(command)

    def wait(self, duration: float) -> None:
        """Let time pass; see `ports.Clock`."""
        self.operations.append(("wait", duration))
        start = time.perf_counter()
        self.robot.wait(duration)
        self.seconds["physics"] += time.perf_counter() - start

    def now(self) -> float:
        """Return the robot's time [s]."""
        return self.robot.now()

    def capture(self) -> Frame | None:
        """Expose a frame; see `ports.Camera`."""
        self.operations.append(("frame",))
        start = time.perf_counter()
        frame = self.robot.capture()
        self.seconds["camera"] += time.perf_counter() - start
        self.frames += 1
        self.last_frame = frame if frame is not None else self.last_frame
        return frame

    def drain(self) -> list[Operation]:
        """Return the operations since the last call and forget them."""
        drained, self.operations = self.operations, []
        return drained

    def stop(self) -> None:
        """Set both wheels to zero."""
        self.robot.command(STOP)


def replay(robot: ReplayableRobot, operations: Iterable[Sequence[Any]]) -> None:
    """Do logged operations again, frames skipped.

    Raises
    ------
    DataError
        An operation of an unknown kind.
    """
    for kind, *values in operations:
        if kind == "command":
            robot.command(WheelCommand(*values))
        elif kind == "wait":
            robot.wait(*values)
        elif kind == "frame":
            robot.skip_frame()
        else:
            raise DataError(f"unknown operation {kind!r} in the journal", cure="Run again without --resume.")
