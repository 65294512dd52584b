"""A served Duckiebot behind a DTPS switchboard of its own: ente's topics for the wheels, camera and encoders."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from queue import Queue
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsm_calib.robots.dtps.library import message
from fsm_calib.robots.dtps.link import OWN, SERVED_SEND, DtpsLink
from fsm_calib.robots.dtps.topics import NAMES
from fsm_calib.robots.guard.pwm import floored, level_of
from fsm_calib.robots.served.settings import ServeSettings
from fsm_calib.robots.served.station import Station
from fsm_calib.types import Pose2, WheelCommand
from fsm_calib.world2d.robot import World

KEPT = {"image": 3, "wheels": 3}
"""Messages that a topic keeps, as ente's; the others keep more, so that lockstep loses none."""
KEPT_ELSE = 1000
ENCODERS = {"left_tick", "right_tick"}
NOT_SERVED = {"estop"}
"""Whoever wants this project's own emergency stop makes its topic; a robot has its driver's."""


class DtpsServedNode:
    """The served robot and its switchboard.

    Parameters
    ----------
    world : World
        The simulated world.
    settings : ServeSettings
        Delays and losses.
    host, port : str, int
        Where the switchboard listens.
    vehicle : str
        What topics begin with.
    encode : callable
        Returns an image (uint8) as JPEG bytes.
    lockstep : bool
        Time passes only when a client asks for it; else as on the wall.

    Raises
    ------
    InputError
        Duckietown's library is not installed.
    LinkLost
        The port is taken.
    """

    def __init__(
        self,
        world: World,
        settings: ServeSettings,
        host: str,
        port: int,
        vehicle: str,
        encode: Callable[[NDArray[np.uint8]], bytes],
        lockstep: bool = False,
    ) -> None:
        self._encode, self._settings = encode, settings
        self.station = Station(world, settings, self, lockstep)
        self.link = DtpsLink(f"{OWN}http://{host}:{port}/", vehicle, SERVED_SEND)
        offered = NAMES.keys() - NOT_SERVED - (set() if settings.encoders else ENCODERS)
        for name in sorted(offered):
            self.link.create(NAMES[name], KEPT.get(name, KEPT_ELSE))
        published = offered & ({"image", "executed", "stepped"} | ENCODERS)
        self._send = {name: self.link.publisher(NAMES[name]) for name in published}
        self._hear("wheels", "pwm", lambda item: self.station.take(WheelCommand(item.left, item.right)))
        self._hear("emergency_stop", "bool", lambda item: self.station.stop(item.data))
        self._hear("step", "text", lambda item: self.station.step(json.loads(item.data), self._tell_step))
        self.station.start()

    def _hear(self, name: str, kind: str, act: Callable[[Any], None]) -> None:
        """Act on a topic's messages in a thread of its own: the library's must be free to bring and send others."""
        inbox: Queue[Any] = Queue()

        def work() -> None:
            while True:
                act(inbox.get())

        threading.Thread(target=work, daemon=True, name=name).start()
        self.link.subscribe(NAMES[name], kind, inbox.put)

    def _tell_step(self, said: dict[str, Any]) -> None:
        self._send["stepped"](message("text")(data=json.dumps(said)))

    def frame(self, number: int, stamp: float, image: NDArray[np.uint8]) -> None:
        """Publish a frame, without a stamp as ente's driver does; see `served.duckiebot.Outlet`."""
        header = message("header")(txt={"number": number})
        self._send["image"](message("image")(header=header, format="jpeg", data=self._encode(image)))

    def executed(self, command: WheelCommand, number: int, time: float) -> None:
        """Tell the level that was applied; see `served.duckiebot.Outlet`."""
        least = self._settings.dead_zone
        left, right = (level_of(floored(side, least)) for side in (command.left, command.right))
        header = message("header")(txt={"number": number})
        self._send["executed"](message("pwm")(header=header, left=left, right=right))

    def ticks(self, side: str, count: int, time: float) -> None:
        """Publish an encoder's count; see `served.duckiebot.Outlet`."""
        self._send[f"{side}_tick"](message("integer")(data=count))

    def tracked(self, pose: Pose2, time: float) -> None:
        """Publish nothing: recordings are made with ROS; see `served.duckiebot.Outlet`."""

    def close(self) -> None:
        """End it."""
        self.station.close()
        self.link.close()
