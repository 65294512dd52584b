"""What is said, and agreed to, before a real robot's wheels turn."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from fsm_calib.errors import InputError

if TYPE_CHECKING:
    from fsm_calib.robots.address import RobotAddress

PREVENTED = """Ctrl-C, a crash, a program that hangs and a pressed emergency stop put its wheels to zero within 0.3 s.
When the network itself fails while it drives, nothing here can stop it: {unstopped}.
Stay within reach of it, and keep it off tables."""
"""What the guard does, and what it cannot."""
UNSTOPPED = {
    "ros1": "a Duckiebot with ROS 1 keeps its last command",
    "dtps": "a Duckiebot with ente keeps its last command for 1 to 1.5 s",
}
"""What becomes of a robot that nobody reaches, by the kind of its address."""


def confirm(address: RobotAddress, yes: bool, plan: str) -> None:
    """Say what a real robot will do, `plan`, and what nothing here can prevent, and ask.

    Raises
    ------
    InputError
        Nobody agreed.
    """
    typer.echo(f"The robot at {address} {plan}", err=True)
    typer.echo(PREVENTED.format(unstopped=UNSTOPPED[address.kind]), err=True)
    if yes or typer.confirm("Start?", err=True):
        return
    raise InputError("the run was not agreed to", where="--robot", cure="Answer y, or give --yes.")
