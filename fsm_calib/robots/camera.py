"""Frames of a camera on a network by their stamps: the newest, and none that was taken before it was asked for."""

from __future__ import annotations

import threading
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from fsm_calib.types import Frame

Decode = Callable[[bytes], NDArray[np.uint8] | None]


class StampedCamera:
    """Keeps the newest frame and the offset of the robot's clock.

    The robot's time at a frame's arrival is at least its stamp; the least delay seen tells the offset:
    robot's clock = ours + max over frames (stamp - arrival). Frames without stamps go by their arrival.

    Parameters
    ----------
    now : callable
        Our clock [s].
    decode : callable
        Returns the image of JPEG bytes, or None.
    """

    def __init__(self, now: Callable[[], float], decode: Decode) -> None:
        self._now, self._decode = now, decode
        self._changed = threading.Condition()
        self._newest: tuple[float, bytes] | None = None
        self._offset: float | None = None
        self._returned = -1.0
        self.received = 0
        self.last_number = -1
        self.arrivals: list[tuple[float, float]] = []

    def hear(self, stamp: float | None, number: int, data: bytes) -> None:
        """Take a frame as JPEG bytes, with the robot's stamp [s] and its number; one older than the newest goes."""
        arrival = self._now()
        stamp = arrival if stamp is None else stamp
        with self._changed:
            self.received += 1
            self.last_number = number
            self.arrivals.append((stamp, arrival))
            del self.arrivals[:-600]
            offset = stamp - arrival
            self._offset = offset if self._offset is None else max(self._offset, offset)
            if self._newest is None or stamp > self._newest[0]:
                self._newest = (stamp, data)
            self._changed.notify_all()

    def forget(self) -> None:
        """Forget every frame and the clock's offset: they came before our clock was set."""
        with self._changed:
            self._newest, self._offset = None, None
            self.arrivals.clear()

    def wait_for(self, condition: Callable[[], bool], timeout: float) -> bool:
        """Wait for a condition over the frames received; False after `timeout` [s]."""
        with self._changed:
            return self._changed.wait_for(condition, timeout)

    def after(self, asked: float, bound: float) -> tuple[float, bytes] | None:
        """Return (stamp, JPEG bytes) of the newest frame taken after `asked` [s, our clock], or None.

        A frame counts as taken up to `bound` [s] before its stamp; none is returned twice.
        """
        if self._newest is None or self._offset is None:
            return None
        stamp, data = self._newest
        if stamp <= asked + self._offset + bound or stamp <= self._returned:
            return None
        return stamp, data

    def frame_of(self, found: tuple[float, bytes], bound: float, index: int) -> Frame | None:
        """Return a found frame with the time at which it was surely not yet taken [s]; None when it is no image."""
        stamp, data = found
        self._returned = stamp
        image = self._decode(data)
        if image is None:
            return None
        return Frame(image, stamp - (self._offset or 0.0) - bound, index)
