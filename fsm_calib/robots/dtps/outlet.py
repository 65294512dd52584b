"""The wheels of a Duckiebot with DTPS: commands out, acknowledgements, encoders and stops in.

The driver acknowledges the PWM that it applied, not the command; see `guard.pwm.command_of`. Who publishes cannot be
asked for: a foreign driver is noticed by its acknowledgements.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from queue import Queue
from typing import Any

from fsm_calib.errors import LinkLost
from fsm_calib.robots.dtps.library import message
from fsm_calib.robots.dtps.link import SEND, SERVED_SEND, DtpsLink, Send
from fsm_calib.robots.dtps.topics import NAMES, RESOLUTION
from fsm_calib.robots.guard.outlet import Event
from fsm_calib.robots.guard.pwm import command_of
from fsm_calib.robots.guard.setup import GuardSetup
from fsm_calib.robots.stepper import Stepper
from fsm_calib.types import WheelCommand


class DtpsOutlet:
    """A client that publishes wheel commands and listens to what becomes of them; see `guard.outlet.Outlet`.

    Raises
    ------
    LinkLost
        No switchboard, or no wheel driver behind it.
    """

    def __init__(self, setup: GuardSetup, inbox: Queue[Event]) -> None:
        self._inbox, self._sent, address = inbox, 0, setup.address
        self._command = message("pwm")
        patience = SERVED_SEND if setup.lockstep else max(SEND, setup.settings.echo)
        self._link = DtpsLink(address.url, address.vehicle, patience)
        try:
            if not self._link.exists(NAMES["wheels"]):
                cure = "Check the vehicle's name, and that its wheel driver runs."
                raise LinkLost(f"{address} has no {NAMES['wheels']}", cure=cure)
            self._post = self._poster(setup.lockstep)
            self._listen()
        except BaseException:
            self._link.close()
            raise

    def _poster(self, lockstep: bool) -> Send:
        """Return what sends a command; in lockstep it waits, since no time passes meanwhile."""
        if lockstep:
            return self._link.publisher(NAMES["wheels"])
        return self._link.poster(NAMES["wheels"], lambda why: self._inbox.put(("lost", why)))

    def _listen(self) -> None:
        """Hear acknowledgements, and encoders and stops where the robot has them."""

        def executed(item: Any) -> None:
            self._inbox.put(("executed", applied_command(item), (item.header.txt or {}).get("number", 0)))

        def stopped(item: Any) -> None:
            if item.data:
                self._inbox.put(("estop", "The emergency stop was pressed"))

        self._link.subscribe(NAMES["executed"], "pwm", executed)
        listeners: dict[str, tuple[str, Callable[[Any], None]]] = {
            "emergency_stop": ("bool", stopped),
            "estop": ("bool", stopped),
            "left_tick": ("integer", self._encoder("left")),
            "right_tick": ("integer", self._encoder("right")),
        }
        for name, (kind, listener) in listeners.items():
            if self._link.exists(NAMES[name]):
                self._link.subscribe(NAMES[name], kind, listener)

    def _encoder(self, side: str) -> Callable[[Any], None]:
        """Return the listener of one wheel's encoder."""
        return lambda item: self._inbox.put(("angle", side, item.data * 2.0 * math.pi / RESOLUTION))

    def send(self, command: WheelCommand) -> None:
        """Publish a command, in real time without waiting: a push ends in time, however long a message takes.

        A message that nobody takes is a lost link.
        """
        self._sent += 1
        try:
            self._post(self._command(left=command.left, right=command.right))
        except LinkLost as lost:
            self._inbox.put(("lost", lost.problem))

    def check_alone(self) -> None:
        """Check nothing: a switchboard does not tell who publishes."""

    @property
    def sent(self) -> int:
        """Commands sent so far."""
        return self._sent

    def stepper(self) -> Stepper:
        """Return what lets a served robot's time pass; see `guard.outlet.Outlet`.

        Raises
        ------
        LinkLost
            Nobody serves steps.
        """
        if not self._link.exists(NAMES["step"]):
            raise LinkLost("the robot serves no steps", cure="Serve it in lockstep.")
        text, ask = message("text"), self._link.publisher(NAMES["step"])
        stepper = Stepper(lambda question: ask(text(data=question)))
        self._link.subscribe(NAMES["stepped"], "text", lambda item: stepper.hear(item.data))
        return stepper

    def close(self) -> None:
        """Leave the switchboard."""
        self._link.close()


def applied_command(item: Any) -> WheelCommand:
    """Return the command that an acknowledgement tells: the middle of its PWM step on either side."""
    return WheelCommand(command_of(item.left), command_of(item.right))
