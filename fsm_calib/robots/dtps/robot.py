"""A Duckiebot with DTPS behind `ports.Robot`."""

from __future__ import annotations

from typing import Any

from fsm_calib.errors import LinkLost
from fsm_calib.robots.dtps.library import message
from fsm_calib.robots.dtps.link import DtpsLink
from fsm_calib.robots.dtps.topics import NAMES
from fsm_calib.robots.guarded import GuardedRobot


class DtpsRobot(GuardedRobot):
    """See `GuardedRobot`. Made by `connect_dtps`."""

    least_bound = 0.2
    """Frames carry no stamp: one counts as taken up to so long before it arrived [s]."""
    link: DtpsLink | None = None

    def _join(self) -> None:
        address = self._setup.address
        self.link = DtpsLink(address.url, address.vehicle)
        if not self.link.exists(NAMES["image"]):
            cure = "Check the vehicle's name, and that its camera driver runs."
            raise LinkLost(f"{address} has no {NAMES['image']}", cure=cure)
        self._standby = self.link.poster(NAMES["wheels"], _ignore)
        self.link.subscribe(NAMES["image"], "image", self._hear)

    def _hear(self, item: Any) -> None:
        """Take a message of the camera; a served one tells its number."""
        number = (item.header.txt or {}).get("number", self.camera.received)
        self.camera.hear(item.header.timestamp, number, item.data)

    def _send_zero(self) -> None:
        self._standby(message("pwm")(left=0.0, right=0.0))

    def _leave(self) -> None:
        if self.link is not None:
            self.link.close()


def _ignore(why: str) -> None:
    """Ignore that a zero was not taken: it is the last thing that can be tried."""
