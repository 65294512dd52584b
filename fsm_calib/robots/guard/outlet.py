"""Where a guard's commands go: one outlet for each kind of robot."""

from __future__ import annotations

from queue import Queue
from typing import Any, Protocol

from fsm_calib.robots.guard.setup import GuardSetup
from fsm_calib.robots.stepper import Stepper
from fsm_calib.types import WheelCommand

Event = tuple[Any, ...]
"""("executed", WheelCommand, its number), ("angle", side, rad), ("estop", problem), ("lost", problem), ("line", list),
("end",). A served robot numbers what it has applied from 1 on; other drivers number as they like.
"""


class Outlet(Protocol):
    """The wheels of one robot; what it hears goes to the guard's inbox as events."""

    def send(self, command: WheelCommand) -> None:
        """Send a command to the driver."""
        ...

    def check_alone(self) -> None:
        """Raise `EmergencyStopped` when somebody else publishes wheel commands."""
        ...

    @property
    def sent(self) -> int:
        """Commands sent so far."""
        ...

    def stepper(self) -> Stepper:
        """Return what lets a served robot's time pass, once its acknowledgements are heard.

        Raises
        ------
        LinkLost
            Nobody serves steps.
        """
        ...

    def close(self) -> None:
        """End the connection."""
        ...


def open_outlet(setup: GuardSetup, inbox: Queue[Event]) -> Outlet:
    """Return the outlet for a guard's robot.

    Raises
    ------
    RobotLost
        The robot does not answer, or somebody else drives it.
    """
    if setup.address.kind == "dtps":
        from fsm_calib.robots.dtps.outlet import DtpsOutlet

        return DtpsOutlet(setup, inbox)
    from fsm_calib.robots.ros1.outlet import Ros1Outlet

    return Ros1Outlet(setup.address, inbox)
