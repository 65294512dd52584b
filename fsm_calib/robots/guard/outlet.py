"""Where a guard's commands go: one outlet for each kind of robot."""

from __future__ import annotations

from queue import Queue
from typing import Any, Protocol

from fsm_calib.robots.guard.setup import GuardSetup
from fsm_calib.types import WheelCommand

Event = tuple[Any, ...]
"""("executed", WheelCommand), ("angle", side, rad), ("estop", problem), ("lost", problem), ("line", list), ("end",)."""


class Outlet(Protocol):
    """The wheels of one robot; what it hears goes to the guard's inbox as events."""

    def send(self, command: WheelCommand) -> None:
        """Send a command to the driver."""
        ...

    def check_alone(self) -> None:
        """Raise `EmergencyStopped` when somebody else publishes wheel commands."""
        ...

    def close(self) -> None:
        """End the connection."""
        ...


def open_outlet(setup: GuardSetup, inbox: Queue[Event]) -> Outlet:
    """Return the outlet for a guard's robot, one with ROS 1.

    Raises
    ------
    RobotLost
        The robot does not answer, or somebody else drives it.
    """
    from fsm_calib.robots.ros1.outlet import Ros1Outlet

    return Ros1Outlet(setup.address, inbox)
