"""A Duckiebot with DTPS as the subject of an owner's first test: a connection that listens beside the program's."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import Any

from fsm_calib.errors import LinkLost
from fsm_calib.robots.camera import Decode
from fsm_calib.robots.dtps.library import message
from fsm_calib.robots.dtps.link import DtpsLink
from fsm_calib.robots.dtps.outlet import applied_command
from fsm_calib.robots.dtps.robot import DtpsRobot
from fsm_calib.robots.dtps.topics import NAMES
from fsm_calib.robots.guard.setup import GuardSetup
from fsm_calib.robots.subject import Heard


class DtpsSubject:
    """See `robots.subject.Subject`.

    Raises
    ------
    InputError
        Duckietown's library is not installed.
    RobotLost
        The robot does not answer, or must not be driven.
    """

    least_command = 0.22
    """ente's driver releases a wheel whose command is 0.2 or less."""
    turning = 0.3

    def __init__(self, setup: GuardSetup, decode: Decode) -> None:
        self.robot, self.heard = DtpsRobot(setup, decode), Heard(decode)
        with contextlib.ExitStack() as opened:
            opened.callback(self.robot.close)
            self._link = DtpsLink(setup.address.url, setup.address.vehicle)
            opened.callback(self._link.close)
            self._listen()
            self._press = self._link.publisher(NAMES[self._button()])
            opened.pop_all()
        self._is_pressed = False

    def _listen(self) -> None:
        """Hear frames and acknowledgements, and encoders where the robot has them."""
        link, heard = self._link, self.heard
        link.subscribe(NAMES["image"], "image", lambda item: heard.frame(item.data))
        link.subscribe(NAMES["executed"], "pwm", lambda item: heard.execute(applied_command(item)))
        for side in ("left", "right"):
            topic = NAMES[f"{side}_tick"]
            if link.exists(topic):
                link.subscribe(topic, "integer", self._counter(side))

    def _counter(self, side: str) -> Callable[[Any], None]:
        return lambda item: self.heard.count(side, item.data)

    def _button(self) -> str:
        """Return the emergency stop to press: this project's own where somebody made its topic, else the driver's."""
        return "estop" if self._link.exists(NAMES["estop"]) else "emergency_stop"

    def press_stop(self) -> None:
        """Press the emergency stop; it stays pressed until `close`."""
        self._is_pressed = True
        self._press(message("bool")(data=True))

    def close(self) -> None:
        """Stop the wheels, release the emergency stop and end the connections.

        A switchboard hands a topic's last message to whoever joins: a stop that is not released ends the next run.
        """
        self.robot.close()
        if self._is_pressed:
            with contextlib.suppress(LinkLost):  # who has gone needs no release
                self._press(message("bool")(data=False))
        self._link.close()
