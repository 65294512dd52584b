"""A robot behind the same socket that keeps a log of what it was commanded.

The log is what makes a killed run resumable: a simulated world, driven by the same commands from the same
seed, ends in the same state, and no frame has to be rendered again on the way.
"""

from __future__ import annotations

import math
from dataclasses import replace

from fsm_calib.errors import DataError
from fsm_calib.ports import Robot
from fsm_calib.runner.parts import Parts
from fsm_calib.types import STOP, Frame, WheelCommand

LoggedCommand = tuple[float, float, float]
"""Robot time [s], left and right command [1]."""


class LoggedRobot:
    """Passes every call on, logs the commands, and charges physics and rendering to their parts.

    Parameters
    ----------
    robot : Robot
        The robot that does the work.
    parts : Parts
        Where wall time is charged.
    frames : int
        Frames that were taken before, in a run that goes on.
    began : float
        The run's time when the robot was connected [s]: a real robot's clock begins anew when a run goes on.
    """

    def __init__(self, robot: Robot, parts: Parts, frames: int = 0, began: float = 0.0) -> None:
        self._robot, self._parts, self._began = robot, parts, began
        self._commands: list[LoggedCommand] = []
        self.frames = frames

    def command(self, command: WheelCommand) -> None:
        """Apply a command; see `ports.WheelDrive`."""
        self._log(command)
        self._robot.command(command)

    def run(self, command: WheelCommand, duration: float) -> None:
        """Apply a command for `duration` [s], then zero; see `ports.WheelDrive`."""
        self._log(command)
        with self._parts.part("physics"):
            self._robot.run(command, duration)
        self._log(STOP)

    def _log(self, command: WheelCommand) -> None:
        """Note a command with the time at which it begins.

        Raises
        ------
        DataError
            The command is not finite.
        """
        if not (math.isfinite(command.left) and math.isfinite(command.right)):
            raise DataError(
                f"a wheel command is not finite: {command}", cure="Report it with scenario and seed."
            )
        self._commands.append((self.now(), command.left, command.right))

    def wait(self, duration: float) -> None:
        """Let time pass; see `ports.Clock`."""
        with self._parts.part("physics"):
            self._robot.wait(duration)

    def now(self) -> float:
        """Return the robot's time [s]."""
        return self._began + self._robot.now()

    def capture(self) -> Frame | None:
        """Expose a frame; see `ports.Camera`."""
        self.frames += 1
        with self._parts.part("rendering"):
            frame = self._robot.capture()
        if frame is None or self._began == 0.0:
            return frame
        return replace(frame, time=self._began + frame.time)

    def drain(self) -> list[LoggedCommand]:
        """Return the commands since the last call and forget them."""
        drained, self._commands = self._commands, []
        return drained

    def stop(self) -> None:
        """Set both wheels to zero; not logged, for use when a run ends."""
        self._robot.command(STOP)
