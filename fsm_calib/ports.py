"""What a robot is to us: three sockets that a simulated and a real robot both fit.

Every call of a real robot may raise `errors.RobotLost`: the link is gone, or the wheels were stopped for safety. The
activities do not catch it; the runner ends the run with it.

The actions know a robot only through these protocols; there is no way from here to the truth of a simulated world.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from fsm_calib.types import Frame, WheelCommand


@runtime_checkable
class Clock(Protocol):
    """Robot time [s], monotonic from zero at the start of the run."""

    def now(self) -> float:
        """Return the time [s]."""
        ...

    def wait(self, duration: float) -> None:
        """Let `duration` [s] pass while the wheels keep their last command."""
        ...


@runtime_checkable
class WheelDrive(Protocol):
    """Two driven wheels."""

    def command(self, command: WheelCommand) -> None:
        """Apply a command at once; it holds until the next one."""
        ...

    def run(self, command: WheelCommand, duration: float) -> None:
        """Apply a command for `duration` [s], then zero; returns when the wheels are at zero.

        A real robot's wheels are timed next to their driver: a program that wakes late lengthens no push.
        """
        ...


@runtime_checkable
class Camera(Protocol):
    """A camera that hands out single frames."""

    def capture(self) -> Frame | None:
        """Expose one frame now and return it; None when the camera delivered nothing."""
        ...


@runtime_checkable
class Robot(WheelDrive, Camera, Clock, Protocol):
    """All of it in one object: wheels, camera and clock."""


@runtime_checkable
class Tracker(Protocol):
    """Something beside the robot, or on it, that tells where the robot was seen."""

    def poses(self) -> list[tuple[float, float, float, float]]:
        """Return what was seen since the last call: time [s, robot time], x, y [m], theta [rad, not wrapped]."""
        ...
